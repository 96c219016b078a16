"""A scene with something in every place, and its file to break."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pickcli.cell.cell import Cell
from pickcli.geometry import pose
from pickcli.scene.scene import TOTE, PlacedItem, PoseNoise, Scene

Refused = Callable[[Callable[[], object]], str]


def make_scene(cell: Cell) -> Scene:
    """One box on the floor of every bin and a sphere in the tote."""
    item, ball = cell.item("crayola_24_ct"), cell.item("rawlings_baseball")
    placed = [
        PlacedItem(
            id=f"crayola_24_ct#{i}",
            item=item,
            location=name,
            T_world_item=b.T_carrier_place
            @ pose((0.33, 0.0, b.room.floor_back + 0.0125), rpy=(0, 0, 0.1 * i)),
        )
        for i, (name, b) in enumerate(cell.pod.bins.items())
    ]
    in_tote = PlacedItem(
        "rawlings_baseball", ball, TOTE, cell.places["tote"].T_carrier_place @ pose((0, 0, 0.034))
    )
    return Scene(cell, cell.T_world_pod, (*placed, in_tote), PoseNoise(0.002, 0.0175), seed=3)


def edit(path: Path, change: Callable[[dict[str, Any]], None]) -> None:
    content = json.loads(path.read_text())
    change(content)
    path.write_text(json.dumps(content, indent=1))


def put_at(*path: Any, value: Any) -> Callable[[dict[str, Any]], None]:
    def change(content: dict[str, Any]) -> None:
        target = content
        for part in path[:-1]:
            target = target[part]
        if value is None:
            del target[path[-1]]
        else:
            target[path[-1]] = value

    return change
