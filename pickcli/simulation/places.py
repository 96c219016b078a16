"""Where an item lies: in which place of the cell, a bin, the tote or one of its own, or in none."""

from __future__ import annotations

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, inverse
from pickcli.scene.scene import Scene

OUTSIDE = "outside"  # on the floor, the table, the robot: in no place
UNDER_BOARD = 0.01  # m under a board within which an item that is seen lies on it: none hangs from it
RIM_SLACK = 0.1  # m over the tote's rim at which the centre of a heaped item still counts as in it


def location_of(scene: Scene, item: Item, T_world_item: Array) -> str:
    """Where an item lies, by its centre.

    Args:
        scene: The scene.
        item: The item.
        T_world_item: (4, 4) pose.

    Returns:
        Name of the place, or OUTSIDE.
    """
    for name, place in scene.cell.places.items():
        if place.holds((inverse(scene.T_world_place(place)) @ T_world_item)[:3, 3], RIM_SLACK):
            return name
    return OUTSIDE


def nearest_place(scene: Scene, T_world_item: Array) -> str:
    """The place whose inside is nearest to an item's centre: for poses that are a little off.

    Args:
        scene: The scene.
        T_world_item: (4, 4) pose.

    Returns:
        Name of the place.
    """
    distances = {}
    for name, place in scene.cell.places.items():
        p, room = (inverse(scene.T_world_place(place)) @ T_world_item)[:3, 3], place.room
        low, high = room.low, room.high
        if place.access.is_from_above:
            high[2] += RIM_SLACK
        else:  # boards slope: the box around one bin's inside reaches into that of the bin below
            low[2], high[2] = room.floor_at(p[0]) - UNDER_BOARD, room.ceiling_at(p[0]) - UNDER_BOARD
        distances[name] = float(np.linalg.norm(np.maximum(np.maximum(low - p, p - high), 0.0)))
    return min(distances, key=distances.__getitem__)


def bounds(shape: Shape, T: Array) -> tuple[Array, Array]:
    """The axis-aligned box around a shape at a pose, exact.

    Args:
        shape: The shape.
        T: (4, 4) pose.

    Returns:
        Lower and upper corner (3,).
    """
    centre, R = T[:3, 3], T[:3, :3]
    if shape.kind is ShapeKind.BOX:
        half = np.abs(R) @ (shape.extents / 2)
    elif shape.kind is ShapeKind.CYLINDER:
        radius, length = shape.size
        half = np.abs(R[:, 2]) * length / 2 + radius * np.sqrt(np.maximum(0.0, 1.0 - R[:, 2] ** 2))
    else:
        half = np.full(3, shape.size[0])
    return centre - half, centre + half
