"""What is unknown of bins after one look into each, and whether items are where nothing is believed to be.

python -m bench.unknown --seeds 1000-1001
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.perceived import SENSORS, SeenBin, fresh_scene, numbers_in, seen_bins
from pickcli.cell.cell_file import load_cell
from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, inverse, transform_points
from pickcli.perception.items.item_observation import PlaceObservation
from pickcli.perception.items.listed_item import ListedItem
from pickcli.seeds import derived_rng

N_POINTS = 400  # on each item
DEEP = 0.005  # m, half a voxel, by which the border of unknown space may be off
PRESSED = 0.002  # m by which items are moved off walls and floor that they are pressed into
EVERY = 29  # px between rays that are followed


@dataclass(frozen=True)
class Row:
    """One bin: points on items that are deep in believed free space, points seen through that are unknown."""

    n_boxes: int
    unknown_share: float
    n_surface: int
    n_missed: int
    n_through: int
    n_blocked: int


def on_surface(shape: Shape, rng: np.random.Generator) -> Array:
    """(N, 3) points on a shape, in its frame."""
    points = rng.uniform(-1.0, 1.0, (N_POINTS, 3))
    if shape.kind is ShapeKind.SPHERE:
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    elif shape.kind is ShapeKind.CYLINDER:
        turn = rng.uniform(0.0, 2.0 * np.pi, N_POINTS)
        points[:, :2] = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    else:
        points[np.arange(N_POINTS), rng.integers(3, size=N_POINTS)] = rng.choice([-1.0, 1.0], N_POINTS)
    return np.asarray(points * shape.extents / 2)


def in_boxes(points: Array, boxes: Array, margin: float = 0.0) -> NDArray[np.bool_]:
    """(N,) whether points are in any of boxes (B, 2, 3), grown by a margin."""
    found = np.zeros(len(points), dtype=bool)
    for low, high in boxes:
        found |= np.logical_and(points >= low - margin, points <= high + margin).all(axis=1)
    return found


def in_answers(observed: PlaceObservation, points: Array) -> NDArray[np.bool_]:
    """(N,) whether points are in an answer, within its bounds and ``DEEP``."""
    found = np.zeros(len(points), dtype=bool)
    for answer in observed.items:
        if answer.bound is not None and answer.T_world_item is not None:
            T = inverse(answer.T_world_item) @ observed.T_world_place
            shape = answer.item.shape.inflated(answer.bound.bound(answer.item) + DEEP)
            found |= shape.contains(transform_points(T, points))
    return found


def row_of(seen: SeenBin) -> Row:
    """Look into a bin, and compare with the truth."""
    observed = seen.perceived([ListedItem(each.id, each.item) for each in seen.items])
    room, boxes = seen.place.room, observed.unknown
    T_place_world = inverse(seen.scene.T_world_place(seen.place))
    rng = derived_rng("unknown", seen.scene.seed, seen.place.name)
    n_missed = 0
    for placed in seen.items:
        points = transform_points(T_place_world @ placed.T_world_item, on_surface(placed.item.shape, rng))
        points = np.clip(points, room.low + PRESSED, room.high - PRESSED)
        points[:, 2] = np.maximum(points[:, 2], room.floor_at(points[:, 0]) + PRESSED)
        n_missed += int((~in_boxes(points, boxes, DEEP) & ~in_answers(observed, points)).sum())
    exact = seen.rendered.seen_by(seen.rgbd.sensor.camera, seen.rgbd.T_world_camera)
    depth = exact.depth[::EVERY, ::EVERY].reshape(-1, 1)
    rays = seen.rgbd.sensor.camera.rays[::EVERY, ::EVERY].reshape(-1, 3)
    along = np.linspace(0.3, 0.95, 14)[:, None, None]
    through = transform_points(
        T_place_world @ seen.rgbd.T_world_camera, (along * rays * depth).reshape(-1, 3)
    )
    is_inside = ((through > room.low + DEEP) & (through < room.high - DEEP)).all(axis=1)
    is_inside &= through[:, 2] > room.floor_at(through[:, 0]) + DEEP
    return Row(
        len(boxes), float((boxes[:, 1] - boxes[:, 0]).prod(axis=1).sum() / room.volume),
        N_POINTS * len(seen.items), n_missed, int(is_inside.sum()),
        int(in_boxes(through[is_inside], boxes).sum()),
    )  # fmt: skip


def report(name: str, rows: Sequence[Row]) -> None:
    """Print the figures of one sensor."""
    missed = sum(r.n_missed for r in rows) / max(sum(r.n_surface for r in rows), 1)
    blocked = sum(r.n_blocked for r in rows) / max(sum(r.n_through for r in rows), 1)
    print(f"{name}: {len(rows)} bins")
    print(f"  unknown {np.mean([r.unknown_share for r in rows]):.0%} of the room, ", end="")
    print(f"{np.mean([r.n_boxes for r in rows]):.0f} boxes, at most {max(r.n_boxes for r in rows)}")
    print(f"  of the surface of items in believed free space, over {1e3 * DEEP:.0f} mm deep: {missed:.2%}")
    print(f"  of what rays truly went through, unknown: {blocked:.1%}")


def main() -> None:
    """Look into all bins of fresh scenes, and print the figures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", default="1000-1001", help="of scenes, e.g. 1000-1005 or 1,2,3")
    parser.add_argument("--sensors", nargs="+", default=list(SENSORS), help="files under data/sensors")
    arguments = parser.parse_args()
    cell = load_cell("apc2016_delft")
    scenes = [fresh_scene(cell, seed) for seed in numbers_in(arguments.seeds)]
    for name in arguments.sensors:
        sensor = read_sensor(sensor_file(name))
        report(name, [row_of(seen) for scene in scenes for seen in seen_bins(scene, sensor)])


if __name__ == "__main__":
    main()
