"""Reads and writes stream files: items that come along a conveyor, as JSON. See docs/formats/stream.md."""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.files.atomic_write import write_text
from pickcli.files.file_kind import STREAM
from pickcli.files.schema import validate
from pickcli.files.source import Source
from pickcli.files.yaml_reader import read_yaml
from pickcli.name_suggestion import suggestion
from pickcli.scene.item_stream import ItemStream, RidingItem
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.scene.scene_checks import FLOATING, ONE_POSE, SUNK, check_id, check_item, check_overlaps
from pickcli.scene.scene_file import cell_of_file, pose_of_model, pose_values
from pickcli.scene.stream_schema import MAX_TIME, StreamModel

FROM_EDGE = 1e-6  # m, rounding of an item that reaches to the edge of the belt


def read_stream(path: Path, cell: Cell | None = None, load: Callable[[str], Cell] = load_cell) -> ItemStream:
    """Read a stream file.

    Args:
        path: The file.
        cell: The stream's cell; loaded by its name if None.
        load: Function that loads a cell by its name.

    Returns:
        The stream.

    Raises:
        InputError: With every mistake and its position.
        StaleError: The file was made for another cell.
    """
    source = read_yaml(Path(path), STREAM, is_json=True)
    model = validate(source, StreamModel)
    cell = cell_of_file(source, model.cell, cell, load, "stream")
    _check_names(source, model, cell)
    stream = ItemStream(
        cell,
        model.conveyor,
        model.speed,
        model.speed_error,
        PoseNoise(**model.noise.model_dump()),
        tuple(
            RidingItem(
                m.id,
                cell.items[m.name, m.year],
                m.stamp,
                pose_of_model(source, ("items", i), m),
                None if m.noise is None else PoseNoise(**m.noise.model_dump()),
            )
            for i, m in enumerate(model.items)
        ),
        model.seed,
        model.one_by_one,
    )
    if model.one_by_one and model.speed + model.speed_error > 0.0:
        text = "items are set down one by one on a belt that stands; leave it out, or state a speed of 0"
        source.add(("one_by_one",), text)
    if 0.0 < model.speed <= model.speed_error:
        could_stand = f"a belt that runs at {model.speed:g} m/s could stand then"
        text = f"{model.speed_error:g} m/s: {could_stand}; state a smaller error"
        source.add(("speed_error",), text)
    source.check()
    _check_poses(source, stream)
    source.check()
    if not stream.one_by_one:
        check_overlaps(source, _at_one_time(stream))
    source.check()
    return stream


def write_stream(stream: ItemStream, path: Path, replace: bool = True) -> None:
    """Write a stream file atomically.

    Args:
        stream: The stream.
        path: The file.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written.
    """
    head: dict[str, Any] = {
        "format": "apc stream",
        "version": 1,
        "cell": {
            "name": stream.cell.name,
            "fingerprint": stream.cell.scene_fingerprint,
            **stream.cell.equipment,
        },
        "conveyor": stream.conveyor,
        "speed": stream.speed,
        "speed_error": stream.speed_error,
        "noise": stream.noise.figures,
        **({"one_by_one": True} if stream.one_by_one else {}),
        "seed": stream.seed,
    }
    lines = [f"  {json.dumps(key)}: {json.dumps(value)}," for key, value in head.items()]
    items = ",\n".join("    " + json.dumps(_item_values(riding)) for riding in stream.items)
    write_text(Path(path), "\n".join(["{", *lines, '  "items": [', items, "  ]", "}"]) + "\n", replace)


def _item_values(riding: RidingItem) -> dict[str, Any]:
    return {
        "id": riding.id,
        "name": riding.item.name,
        "year": riding.item.year,
        "stamp": riding.stamp,
        **pose_values(riding.T_belt_item),
        **({} if riding.noise is None else {"noise": riding.noise.figures}),
    }


def _check_names(source: Source, model: StreamModel, cell: Cell) -> None:
    """Check conveyor, speed, ids, names of items and the order of stamps. Raises at once."""
    belts = {each.name: each.conveyor for each in cell.own_carriers if each.conveyor is not None}
    if model.conveyor not in belts:
        hint = suggestion(model.conveyor, list(belts)) if belts else f"cell {cell.name} has none"
        source.add(("conveyor",), f"unknown conveyor {model.conveyor!r}; {hint}")
    elif model.speed > (most := belts[model.conveyor].max_speed):
        text = f"{model.speed:g} m/s is beyond the {most:g} m/s of {model.conveyor}"
        source.add(("speed",), f"{text}; correct it, or speed.max of the conveyor")
    seen = set[str]()
    for i, item in enumerate(model.items):
        if item.id in seen:
            source.add(("items", i, "id"), f"{item.id!r} stands twice; give each item an id of its own")
        seen.add(item.id)
        check_id(source, ("items", i, "id"), item.id, cell)
        check_item(source, ("items", i, "name"), item, cell)
    if late := [i for i, item in enumerate(model.items) if item.stamp > MAX_TIME]:
        text = f"{model.items[late[0]].stamp:g} s is beyond {MAX_TIME:g} s"
        cure = "they count from any moment that all share: subtract the first stamp from all, and from --now"
        source.add(("items", late[0], "stamp"), f"{text}; {cure}")
    for i, (before, after) in enumerate(pairwise(model.items), start=1):
        if after.stamp < before.stamp:
            text = f"{after.stamp:g} s is before {before.stamp:g} s of the item before; sort the items by it"
            source.add(("items", i, "stamp"), text)
    source.check()


def _check_poses(source: Source, stream: ItemStream) -> None:
    """Check that every item stands on the belt, within its width, and as low as its room."""
    belt, height = stream.belt, next(iter(stream.carrier.places.values())).room.ceiling_front
    for i, riding in enumerate(stream.items):
        key = ("items", i, "position")
        reach = riding.item.shape.reach(riding.T_belt_item[:3, :3])
        x, y, z = riding.T_belt_item[:3, 3].tolist()
        error = stream.noise.bound(riding.item)
        beside = abs(y) + float(reach[1]) - belt.width / 2
        under = float(reach[2]) - z
        if beside > FROM_EDGE + error:
            source.add(
                key, f"{riding.id} reaches {1e3 * beside:.1f} mm beyond the edge of the belt; {ONE_POSE}"
            )
        if abs(x) > belt.upstream:
            text = f"{riding.id} is {x:.2f} m from the infeed of a belt of {belt.length:g} m"
            source.add(key, f"{text}; state it at a stamp at which it is on the belt")
        if under > SUNK + error:
            source.add(key, f"{riding.id} stands {1e3 * under:.1f} mm deep in the belt; {ONE_POSE}")
        elif -under > FLOATING + error:
            source.add(key, f"{riding.id} floats {-1e3 * under:.1f} mm over the belt; {ONE_POSE}")
        elif z + float(reach[2]) > height + error:
            text = (
                f"{riding.id} is {1e3 * (z + float(reach[2])):.0f} mm high, the belt takes {1e3 * height:.0f}"
            )
            source.add(key, f"{text}; correct its pose, or height of the conveyor")


def _at_one_time(stream: ItemStream) -> Scene:
    """Return all items as they stand to each other, also those that are not on the belt yet."""
    placed = []
    for riding in stream.items:
        T = riding.T_belt_item.copy()
        T[0, 3] -= stream.speed * riding.stamp
        placed.append(PlacedItem(riding.id, riding.item, stream.conveyor, T))
    return Scene(stream.cell, stream.cell.T_world_pod, tuple(placed), stream.noise)
