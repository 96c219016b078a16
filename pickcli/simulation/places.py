"""Where an item lies: in a bin, in the tote, or outside of both."""

from __future__ import annotations

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, inverse
from pickcli.scene.scene import TOTE, Scene

OUTSIDE = "outside"  # on the floor, the table, the robot: neither in a bin nor in the tote
UNDER_BOARD = 0.01  # m under a board within which an item that is seen lies on it: none hangs from it
RIM_SLACK = 0.1  # m over the tote's rim at which the centre of a heaped item still counts as in it


def location_of(scene: Scene, item: Item, T_world_item: Array) -> str:
    """Name of the bin, TOTE or OUTSIDE, by the item's centre."""
    p_world = T_world_item[:, 3]
    p_tote = (inverse(scene.cell.tote.T_world_tote) @ p_world)[:3]
    half_x, half_y, rim = scene.cell.tote.inner[0] / 2, scene.cell.tote.inner[1] / 2, scene.cell.tote.inner[2]
    if abs(p_tote[0]) <= half_x and abs(p_tote[1]) <= half_y and 0.0 <= p_tote[2] <= rim + RIM_SLACK:
        return TOTE
    return scene.cell.pod.bin_of_point((inverse(scene.T_world_pod) @ p_world)[:3]) or OUTSIDE


def nearest_place(scene: Scene, T_world_item: Array) -> str:
    """Name of the bin, or TOTE, whose inside is nearest to an item's centre: for poses a little off."""
    tote = scene.cell.tote
    p_tote = (inverse(tote.T_world_tote) @ T_world_item[:, 3])[:3]
    p_pod = (inverse(scene.T_world_pod) @ T_world_item[:, 3])[:3]
    x, y, rim = tote.inner
    distances = {TOTE: _beyond(p_tote, (-x / 2, -y / 2, 0.0), (x / 2, y / 2, rim + RIM_SLACK))}
    for name, inside in scene.cell.pod.bins.items():
        point = p_pod - inside.T_pod_bin[:3, 3]
        # Boards slope: the box around one bin's inside reaches into that of the bin below.
        floor, ceiling = float(inside.floor_at(point[0])), float(inside.ceiling_at(point[0]))
        (right, left), depth = inside.y_range, inside.depth
        low, high = (0.0, right, floor - UNDER_BOARD), (depth, left, ceiling - UNDER_BOARD)
        distances[name] = _beyond(point, low, high)
    return min(distances, key=distances.__getitem__)


def _beyond(point: Array, low: tuple[float, float, float], high: tuple[float, float, float]) -> float:
    """m from a point (3,) to the box between two corners; 0 inside."""
    return float(np.linalg.norm(np.maximum(np.maximum(low - point, point - high), 0.0)))


def bounds(shape: Shape, T: Array) -> tuple[Array, Array]:
    """Lower and upper corner (3,), exact, of the axis-aligned box around a shape at a pose."""
    centre, R = T[:3, 3], T[:3, :3]
    if shape.kind is ShapeKind.BOX:
        half = np.abs(R) @ (shape.extents / 2)
    elif shape.kind is ShapeKind.CYLINDER:
        radius, length = shape.size
        half = np.abs(R[:, 2]) * length / 2 + radius * np.sqrt(np.maximum(0.0, 1.0 - R[:, 2] ** 2))
    else:
        half = np.full(3, shape.size[0])
    return centre - half, centre + half
