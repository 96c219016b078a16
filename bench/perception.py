"""How long pictures take: exact depth, depth with noise, and colour, of a full shelf.

    python -m bench.perception [--json FILE]

The scene has four items in each bin of the default cell, seen by the camera on the gripper. CPU time of one
thread, best and median of several runs.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from time import thread_time
from typing import Any

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file
from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.geometry import pose
from pickcli.perception.camera_pose import camera_pose
from pickcli.perception.depth_picture import measure_depth
from pickcli.perception.looks import colour_picture
from pickcli.perception.rendered_scene import RenderedScene
from pickcli.scene.scene import PlacedItem, Scene, empty_scene

N_RUNS = 15
PER_BIN = 4
AT = "cam_E"
SENSORS = ("carmine", "ensenso", "kinect_v2")


def full_shelf(cell: Cell) -> Scene:
    """Four items of 2016 in each bin, in two rows; they may overlap, which pictures do not mind."""
    items = sorted(
        (item for (_, year), item in cell.items.items() if year == 2016), key=lambda item: item.name
    )
    placed = []
    for i, (name, place) in enumerate(cell.pod.bins.items()):
        for k in range(PER_BIN):
            item = items[(PER_BIN * i + k) % len(items)]
            T = pose(
                (0.1 + 0.16 * (k // 2), 0.06 - 0.12 * (k % 2), item.shape.extents[2] / 2),
                rpy=(0.0, 0.0, 0.4 * k),
            )
            T_world_item = cell.T_world_place(place) @ T
            placed.append(PlacedItem(f"{item.name}#{name}", item, name, T_world_item))
    return replace(empty_scene(cell), items=tuple(placed))


def timed(function: Callable[[], object]) -> dict[str, float]:
    """Best and median ms of a function."""
    function()
    times = []
    for _ in range(N_RUNS):
        start = thread_time()
        function()
        times.append(1e3 * (thread_time() - start))
    return {"best_ms": min(times), "median_ms": float(np.median(times))}


def measure() -> dict[str, Any]:
    """All pictures."""
    cell = load_cell("apc2016_delft")
    at, hand = cell.configurations[AT], cell.cameras["hand"]
    T = camera_pose(cell.robot, hand, at.q, at.tool_state)
    rendered = RenderedScene.of(full_shelf(cell), at.q, at.tool_state)
    small, large = PinholeCamera(570.0, 570.0, 319.5, 239.5, 640, 480), hand.model.camera
    found: dict[str, Any] = {"solids": len(rendered.solids)}
    for camera in (small, large):
        size = f"{camera.width}x{camera.height}"
        found[f"exact {size}"] = timed(partial(rendered.seen_by, camera, T))
        for name in SENSORS:
            sensor = replace(read_sensor(sensor_file(name)), camera=camera)
            found[f"{name} {size}"] = timed(partial(measure_depth, rendered, sensor, T, 1))
        found[f"colour {size}"] = timed(partial(colour_picture, rendered, camera, T))
    return found


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--json", type=Path, help="also write the figures there")
    arguments = parser.parse_args()
    found = measure()
    print(f"{found['solids']} solids, ms of one thread (best, median of {N_RUNS})")
    for name, times in found.items():
        if isinstance(times, dict):
            print(f"{name:24s} {times['best_ms']:8.1f} {times['median_ms']:8.1f}")
    if arguments.json is not None:
        arguments.json.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
