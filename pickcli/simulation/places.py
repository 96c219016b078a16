"""Finds the place of the cell that an item lies in: a bin, the tote, a user-defined place, or none."""

from __future__ import annotations

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, inverse
from pickcli.scene.scene import Scene

OUTSIDE = "outside"  # location of items in no place, e.g. on the floor or the robot
UNDER_BOARD = 0.01  # m below a board; an item seen there lies on the board, as none hangs below it
RIM_SLACK = 0.1  # m above a rim within which the centre of a heaped item counts as inside


def location_of(scene: Scene, item: Item, T_world_item: Array) -> str:
    """Return the place that contains an item's centre.

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
    """Return the place nearest to an item's centre, for inexact poses.

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
        else:  # boards slope: the box around a bin's room overlaps that of the bin below
            low[2], high[2] = room.floor_at(p[0]) - UNDER_BOARD, room.ceiling_at(p[0]) - UNDER_BOARD
        distances[name] = float(np.linalg.norm(np.maximum(np.maximum(low - p, p - high), 0.0)))
    return min(distances, key=distances.__getitem__)


def bounds(shape: Shape, T: Array) -> tuple[Array, Array]:
    """Compute the exact axis-aligned bounding box of a shape at a pose.

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
