"""What solids are, spelled out: oracles of overlaps and gaps."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array
from pickcli.scene.solid_overlap import PosedSolid

UNIT_BALL = np.random.default_rng(8).uniform(-1.0, 1.0, size=(4000, 3))


def points_inside(solid: PosedSolid) -> Array:
    """Points of a solid, common frame."""
    local = UNIT_BALL * solid.shape.extents / 2
    return np.asarray(local[is_inside(solid.shape, local)] @ solid.T[:3, :3].T + solid.T[:3, 3])


def is_inside(shape: Shape, p: Array) -> NDArray[np.bool_]:
    """Whether points (N, 3) of the shape's frame lie in the shape: its definition, spelled out."""
    if shape.kind is ShapeKind.BOX:
        return np.asarray(np.all(abs(p) <= shape.extents / 2, axis=1))
    if shape.kind is ShapeKind.SPHERE:
        return np.asarray(np.linalg.norm(p, axis=1) <= shape.size[0])
    return (np.hypot(p[:, 0], p[:, 1]) <= shape.size[0]) & (abs(p[:, 2]) <= shape.size[1] / 2)


def corners(solid: PosedSolid, n: int = 48) -> Array:
    """Points (K, 3) whose hull is a box, or is inscribed in a cylinder; common frame."""
    if solid.shape.kind is ShapeKind.BOX:
        local = np.array(list(product((-0.5, 0.5), repeat=3))) * solid.shape.extents
    else:
        radius, length = solid.shape.size
        turns = 2 * np.pi * np.arange(n) / n
        rim = np.column_stack([radius * np.cos(turns), radius * np.sin(turns)])
        local = np.array([(x, y, z) for x, y in rim for z in (-length / 2, length / 2)])
    return np.asarray(local @ solid.T[:3, :3].T + solid.T[:3, 3])


def hull_depth(a: PosedSolid, b: PosedSolid) -> float:
    """How deep the hulls of the corners of two solids stand in each other, m; 0 where they do not.

    All differences of their points have a hull, and moving by the way from 0 to its surface parts them.
    """
    differences = (corners(a)[:, None] - corners(b)).reshape(-1, 3)
    return max(0.0, float(-ConvexHull(differences).equations[:, 3].max()))
