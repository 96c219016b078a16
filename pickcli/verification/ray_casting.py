"""Ray casting: parameters at which parallel rays enter and leave a solid."""

from __future__ import annotations

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array

PARALLEL = 1e-12  # replaces components of 0 of a direction, to divide by them
FLAT_AXES = {ShapeKind.BOX: (0, 1, 2), ShapeKind.CYLINDER: (2,), ShapeKind.SPHERE: ()}


def cast_rays(shape: Shape, starts: Array, along: Array) -> tuple[Array, Array]:
    """Cast parallel rays at a shape.

    A ray is inside a convex solid between its last entry into, and its first exit from, the slabs between
    parallel faces and the round side (Kay and Kajiya, Ray tracing complex scenes, 1986).

    Args:
        shape: A box, cylinder or sphere.
        starts: (N, 3) m, a point of each ray in the shape's own frame.
        along: (3,) unit direction of all rays in that frame.

    Returns:
        (N,) m each: distances from the start of the ray to entry and exit; NaN if it misses the solid.
    """
    along = np.where(np.abs(along) < PARALLEL, PARALLEL, along)
    enters, leaves = np.full(len(starts), -np.inf), np.full(len(starts), np.inf)
    for axis in FLAT_AXES[shape.kind]:
        ends = (np.array([[-0.5], [0.5]]) * shape.extents[axis] - starts[:, axis]) / along[axis]
        enters, leaves = np.maximum(enters, ends.min(axis=0)), np.minimum(leaves, ends.max(axis=0))
    if round_axes := [axis for axis in range(3) if axis not in FLAT_AXES[shape.kind]]:
        off, way = starts[:, round_axes], along[round_axes]
        a, b = float(way @ way), off @ way
        with np.errstate(invalid="ignore"):  # no root: NaN
            half = np.sqrt(b * b - a * ((off**2).sum(axis=1) - shape.size[0] ** 2))
        enters, leaves = np.maximum(enters, (-b - half) / a), np.minimum(leaves, (-b + half) / a)
    is_met = enters <= leaves
    return np.where(is_met, enters, np.nan), np.where(is_met, leaves, np.nan)
