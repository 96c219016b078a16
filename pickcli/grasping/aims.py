"""Places on a face that are chosen and not drawn: a grid over a flat one, straight aims at a curved one."""

from __future__ import annotations

from itertools import product

import numpy as np

from pickcli.cell.item import Item
from pickcli.geometry import Array, pose, rotation_axis_angle
from pickcli.grasping.search import Search
from pickcli.grasping.surfaces import Face, into

WAYS_IN = np.array(
    [[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]
)  # outward, bin frame
NEARLY_PARALLEL = 0.3  # of a unit vector across a cylinder's axis, below which the mantle does not face a way


def aims(face: Face, item: Item, T_bin_item: Array, search: Search) -> list[Array]:
    """Choose places on a face: a grid over a flat one, straight aims at a curved one.

    Args:
        face: The face.
        item: The item that has it.
        T_bin_item: (4, 4) pose of the item in the frame of the way into its bin.
        search: How fine the grid is, and the angles of the fan.

    Returns:
        (4, 4) tool poses in the item frame, their turn about the cup's axis as it comes.
    """
    if face.name in ("mantle", "sphere"):
        return _at_curved(face, item.shape.size[0], T_bin_item, search)
    if search.grid < 2:
        return []
    low, high = face.region.bounds[:2, 0], face.region.bounds[:2, 1]
    shares = list(product(np.linspace(0.0, 1.0, search.grid), repeat=2))
    return [face.region.pose_at(np.array([*(low + (high - low) * s), 0.0, 0.0, 0.0, 0.0])) for s in shares]


def _at_curved(face: Face, radius: float, T_bin_item: Array, search: Search) -> list[Array]:
    """Straight at the mouth, up and to the sides, and turned from there by the angles of the fan."""
    is_mantle = face.name == "mantle"
    low, high = face.region.bounds[2] if is_mantle else np.zeros(2)
    heights = np.linspace(low, high, search.grid) if search.grid > 1 and high > low else [(low + high) / 2]
    found: dict[tuple[float, ...], Array] = {}
    for toward, a, b in product(WAYS_IN, search.fan, search.fan):
        outward = T_bin_item[:3, :3].T @ _turned_off(toward, a, b)
        if is_mantle:
            outward[2] = 0.0  # around the cylinder's axis only
        length = float(np.linalg.norm(outward))
        if length >= NEARLY_PARALLEL:
            found.setdefault(tuple(np.round(outward / length, 1)), outward / length)
    return [pose(radius * n + (0.0, 0.0, h), R=into(n)) for n in found.values() for h in heights]


def _turned_off(toward: Array, a: float, b: float) -> Array:
    """A direction (3,) turned about the two axes of the bin that are across it."""
    i = int(np.argmax(np.abs(toward)))
    across = np.eye(3)[(i + 1) % 3], np.eye(3)[(i + 2) % 3]
    return np.asarray(rotation_axis_angle(across[0], a) @ rotation_axis_angle(across[1], b) @ toward)
