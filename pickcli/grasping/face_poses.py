"""Deterministic tool poses on a face: a grid on a flat face, approach directions on a curved one."""

from __future__ import annotations

from itertools import product

import numpy as np

from pickcli.cell.item import Item
from pickcli.geometry import Array, pose
from pickcli.grasping.search import Search
from pickcli.grasping.surfaces import Face, into

NEARLY_PARALLEL = 0.3  # least component across a cylinder's axis for which the mantle can be approached


def face_poses(face: Face, item: Item, T_entry_item: Array, search: Search) -> Array:
    """Choose tool poses on a face: a grid on a flat face, approach directions on a curved one.

    Args:
        face: The face.
        item: The item with the face.
        T_entry_item: (4, 4) pose of the item in the entry frame of its place.
        search: How fine the grid is, and the angles of the fan.

    Returns:
        (N, 4, 4) tool poses in the item frame, with any turn about the cup's axis.
    """
    if face.name in ("mantle", "sphere"):
        return _at_curved(face, item.shape.size[0], T_entry_item, search)
    shares = np.linspace(0.0, 1.0, search.grid)
    low, high = face.region.bounds[:2, 0], face.region.bounds[:2, 1]
    displacements = np.zeros((search.grid**2, 6))
    displacements[:, :2] = low + (high - low) * np.array([*product(shares, shares)]).reshape(-1, 2)
    return face.region.poses_at(displacements)


def _at_curved(face: Face, radius: float, T_entry_item: Array, search: Search) -> Array:
    """Choose poses facing the mouth, up and to the sides, and turned from there by the angles of the fan."""
    is_mantle = face.name == "mantle"
    low, high = face.region.bounds[2] if is_mantle else np.zeros(2)
    heights = np.linspace(low, high, search.grid) if search.grid > 1 and high > low else [(low + high) / 2]
    outward = search.outward @ T_entry_item[:3, :3]
    if is_mantle:
        outward[:, 2] = 0.0  # only around the cylinder's axis
    length = np.linalg.norm(outward, axis=1)
    outward = outward[length >= NEARLY_PARALLEL] / length[length >= NEARLY_PARALLEL, None]
    _, first = np.unique(np.round(outward, 1) + 0.0, axis=0, return_index=True)
    found = [
        pose(radius * n + (0.0, 0.0, h), R=R)
        for n, R in ((n, into(n)) for n in outward[np.sort(first)])
        for h in heights
    ]
    return np.array(found).reshape(-1, 4, 4)
