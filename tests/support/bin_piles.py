"""Items where a test of piles wants them: in one bin of the default cell, over the back part of its floor."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import pose
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.statics.supports import Supports, supports_of

BIN = "bin_E"
EXACT, NOISY = PoseNoise(), PoseNoise(0.002, float(np.radians(1.0)))


def put(
    cell: Cell, name: str, x: float, y: float, z: float = 0.0, rpy: tuple[float, float, float] = (0, 0, 0)
) -> PlacedItem:
    """An item whose lowest point is z over the back part of the floor, in the bin's frame."""
    cell_bin, item = cell.pod.bins[BIN], cell.item(name)
    low = float(item.shape.reach(pose(rpy=rpy)[:3, :3])[2])
    T = pose([x, y, cell_bin.room.floor_back + z + low], rpy=rpy)
    return PlacedItem(name, item, BIN, cell.T_world_place(cell_bin) @ T)


def of(cell: Cell, *items: PlacedItem, noise: PoseNoise = EXACT) -> Supports:
    return supports_of(Scene(cell, cell.T_world_pod, items, noise))


def height(cell: Cell, name: str) -> float:
    return float(cell.item(name).shape.extents[2])


def shaped(cell: Cell, size: tuple[float, ...], kind: ShapeKind = ShapeKind.BOX, mass: float = 0.2) -> Item:
    """An item of any shape, as heavy as told."""
    return replace(cell.item("crayola_24_ct"), shape=Shape(kind, size), mass=mass)


def at(
    cell: Cell, name: str, item: Item, x: float, y: float, z: float, rpy: tuple[float, ...] = (0, 0, 0)
) -> PlacedItem:
    """An item with its middle z over the back part of the floor, in the bin's frame."""
    cell_bin = cell.pod.bins[BIN]
    T = pose([x, y, cell_bin.room.floor_back + z], rpy=rpy)
    return PlacedItem(name, item, BIN, cell.T_world_place(cell_bin) @ T)


def in_a_slot(cell: Cell, angle: float, *more: PlacedItem) -> Supports:
    """A can lying across two plates, its middle over the gap between them.

    angle: degrees between the vertical and the lines from its axis to the edges that carry it
    """
    radius, thick = 0.05, 0.06
    half = radius * float(np.sin(np.radians(angle)))
    plate = shaped(cell, (0.06, 0.14, thick))
    left, right = (at(cell, f"plate{s}", plate, 0.3 + s * (0.03 + half), 0.0, thick / 2) for s in (-1, 1))
    z = thick + radius * float(np.cos(np.radians(angle)))
    can = at(cell, "can", shaped(cell, (radius, 0.1), ShapeKind.CYLINDER), 0.3, 0.0, z, (np.pi / 2, 0.0, 0.0))
    return of(cell, left, right, can, *more)


def on_a_slope(cell: Cell, degrees: float, x: float, z: float) -> tuple[PlacedItem, PlacedItem]:
    """A box that is pitched, with its middle at x and z m in the bin, and a smaller one flat on it."""
    turn = (0.0, float(np.radians(degrees)), 0.0)
    below = at(cell, "below", shaped(cell, (0.12, 0.1, 0.05)), x, 0.0, z, turn)
    T = below.T_world_item @ pose((0.0, 0.0, 0.04))
    return below, PlacedItem("above", shaped(cell, (0.05, 0.05, 0.03)), BIN, T)


def can_on_a_slope(cell: Cell, turn: float) -> tuple[PlacedItem, PlacedItem, PlacedItem]:
    """A plate that falls by 5 degrees along x, a can on it, and a box beside the can, at its mantle.

    turn: rad about the plate's normal from where the can points down the slope
    """
    radius, thick = 0.03, 0.02
    plate = at(cell, "plate", shaped(cell, (0.2, 0.2, thick)), 0.3, 0.0, 0.03, (0.0, float(np.radians(5)), 0))
    T = plate.T_world_item @ pose((0.0, 0.0, thick / 2), rpy=(0.0, 0.0, turn))
    can, box = shaped(cell, (radius, 0.1), ShapeKind.CYLINDER), shaped(cell, (0.04, 0.04, 0.06))
    lying = PlacedItem("can", can, BIN, T @ pose((0.0, 0.0, radius), rpy=(0.0, np.pi / 2, 0.0)))
    return plate, lying, PlacedItem("beside", box, BIN, T @ pose((0.0, -(radius + 0.02), 0.03)))
