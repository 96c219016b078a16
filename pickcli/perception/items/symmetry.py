"""Differences of poses of items whose shapes look alike from several sides."""

from __future__ import annotations

from functools import cache

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, rotation_angle, rotation_axis_angle

SAME_SIDE = 0.002  # m by which two sides of a box may differ and still be taken for each other


@cache
def symmetries(shape: Shape) -> tuple[Array, ...]:
    """List the rotations of a shape onto itself, of a cylinder only those that turn it over.

    Args:
        shape: A box, cylinder or sphere.

    Returns:
        Rotations (3, 3) in the shape's frame. The group of a box has 4, 8 or 24 of them by how many of its
        sides are equal, within ``SAME_SIDE``.
    """
    if shape.kind is ShapeKind.SPHERE:
        return (np.eye(3),)
    if shape.kind is ShapeKind.CYLINDER:
        return np.eye(3), np.diag([1.0, -1.0, -1.0])
    return tuple(
        R for R in _cube_rotations()
        if np.allclose(np.abs(R) @ shape.extents, shape.extents, atol=SAME_SIDE)
    )  # fmt: skip


def turn_between(shape: Shape, R: Array, R_true: Array) -> float:
    """Compute the least angle between two orientations of a shape.

    Args:
        shape: The shape.
        R: (3, 3).
        R_true: (3, 3).

    Returns:
        rad; turns that the shape does not show count as none.
    """
    if shape.kind is ShapeKind.SPHERE:
        return 0.0
    if shape.kind is ShapeKind.CYLINDER:
        return float(np.arccos(np.clip(abs(R[:, 2] @ R_true[:, 2]), 0.0, 1.0)))
    return min(rotation_angle(R.T @ R_true @ S) for S in symmetries(shape))


@cache
def _cube_rotations() -> tuple[Array, ...]:
    quarter = [np.round(rotation_axis_angle(axis, np.pi / 2)) for axis in np.eye(3)]
    found = [np.eye(3)]
    for R in found:
        for turn in quarter:
            if not any(np.array_equal(turn @ R, other) for other in found):
                found.append(turn @ R)
    return tuple(found)
