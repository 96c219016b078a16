"""Distance between two convex solids, by the algorithm of Gilbert, Johnson and Keerthi.

The vectors from points of one solid to points of the other form a convex body, whose point nearest to 0 is
the shortest of them. The algorithm collects corners of that body from the farthest points of the solids, and
finds the nearest point of their hull by non-negative least squares (Lawson and Hanson, Solving Least Squares
Problems, 1974, ch. 23). Each step gives a direction, in which the empty slab between the solids is a lower
bound.
"""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.scene.solid_overlap import PosedSolid

TOLERANCE = 1e-5  # m between the bounds of a distance at which the search ends

_MAX_STEPS = 100
_ROUNDING = 1e-9  # m, distance between two solids within rounding errors


def separation(a: PosedSolid, b: PosedSolid, along: Array) -> tuple[float, Array]:
    """Compute the distance between two solids.

    Args:
        a: One solid.
        b: The other, in the same frame.
        along: (3,) unit vector, a guess of the direction from ``a`` to ``b`` that the search starts with.

    Returns:
        m, a lower bound of the distance, normally ``TOLERANCE`` too small at most, 0 if they touch; and
        the unit vector (3,) from ``a`` to ``b`` along which it is the width of the empty slab between them.
    """
    corners = (b.support(-along) - a.support(along))[None]
    best, across = max(0.0, float(corners[0] @ along)), along
    for _ in range(_MAX_STEPS):
        weights = _weights_nearest_to_zero(corners)
        if weights is None:
            break
        nearest = weights @ corners
        length = float(np.linalg.norm(nearest))
        if length <= max(best + TOLERANCE, _ROUNDING):
            break
        way = nearest / length
        corner = b.support(-way) - a.support(way)
        if float(corner @ way) > best:
            best, across = float(corner @ way), way
        corners = np.vstack([corners[weights > 0.0], corner])
    return best, across


def _weights_nearest_to_zero(corners: Array) -> Array | None:
    """Weights (K,) of corners (K, 3) in the point of their convex hull nearest to 0; None if not found."""
    if len(corners) == 1:
        return np.ones(1)
    if len(corners) == 2:
        edge = corners[1] - corners[0]
        share = -float(corners[0] @ edge) / max(float(edge @ edge), _ROUNDING**2)
        share = min(1.0, max(0.0, share))
        return np.array([1.0 - share, share])
    from scipy.optimize import nnls

    size = max(float(np.abs(corners).max()), _ROUNDING)
    scaled, wanted = np.vstack([corners.T / size, np.ones(len(corners))]), np.array([0.0, 0.0, 0.0, 1.0])
    try:
        weights, _ = nnls(scaled, wanted)
    except RuntimeError:  # no convergence, by rounding of corners that are nearly the same
        return None
    return np.asarray(weights / weights.sum())
