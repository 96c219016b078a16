"""Convex polygons in the plane: where a carton is borne, and where it bears others.

Source: the load-bearable convex polygon of Z. Gao, L. Wang, Y. Kong, N. Y. Chong, "Online 3D bin packing with
fast stability validation and stable rearrangement planning", arXiv 2507.09123 (2025). What stands on the deck
bears within its base. What stands on others is borne within the convex hull of its contacts with the polygons
of those, and bears others in the same hull. If the centre of every carton is over the hull that bears it, the
weight of all leads from hull to hull down to the deck, and none of them tips: by induction from the deck, no
carton can be loaded outside of the polygon that its own support was proven for.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from pickcli.geometry import Array

EMPTY = np.empty((0, 2))
SAME_POINT = 1e-9  # m


def rectangle(low: Array, high: Array) -> Array:
    """Return the corners of a rectangle.

    Args:
        low: (2,) m, its lower corner.
        high: (2,) m, its upper corner.

    Returns:
        (4, 2) m, counter-clockwise.
    """
    return np.array([low, (high[0], low[1]), high, (low[0], high[1])])


def clipped(polygon: Array, low: Array, high: Array) -> Array:
    """Return the part of a polygon inside of a rectangle.

    Source: I. Sutherland, G. Hodgman, "Reentrant polygon clipping", Communications of the ACM 17(1), 1974.

    Args:
        polygon: (K, 2) m, corners of a convex polygon in order.
        low: (2,) m, lower corner of the rectangle.
        high: (2,) m, its upper corner.

    Returns:
        (N, 2) m, corners in order; none if the two are apart.
    """
    for axis in (0, 1):
        for sign, bound in ((1.0, high[axis]), (-1.0, -low[axis])):
            polygon = _cut(polygon, sign * polygon[:, axis] - bound)
    return polygon


def hull(points: Array) -> Array:
    """Return the convex hull of points.

    Source: A. M. Andrew, "Another efficient algorithm for convex hulls in two dimensions", Information
    Processing Letters 9(5), 1979.

    Args:
        points: (N, 2) m.

    Returns:
        (K, 2) m, its corners, counter-clockwise; one or two if all points are on a line.
    """
    ordered = sorted(set(map(tuple, points.tolist())))
    if len(ordered) < 3:
        return np.array(ordered).reshape(-1, 2)
    lower, upper = _chain(ordered), _chain(reversed(ordered))
    return np.array([*lower[:-1], *upper[:-1]])


def depth_inside(polygon: Array, points: Array) -> float:
    """Return how far inside of a convex polygon all of some points are.

    Args:
        polygon: (K, 2) m, corners, counter-clockwise.
        points: (N, 2) m.

    Returns:
        m of the point that is nearest to an edge or farthest outside, negative outside; minus infinity if the
        polygon has no area.
    """
    if len(polygon) < 3:
        return -np.inf
    along = np.roll(polygon, -1, axis=0) - polygon
    inwards = np.column_stack([-along[:, 1], along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None]
    return float(np.einsum("nki,ki->nk", points[:, None] - polygon, inwards).min())


def _cut(polygon: Array, beyond: Array) -> Array:
    """Return the part of a polygon (K, 2) where a linear function, known at its corners (K,), is <= 0."""
    corners: list[Array] = []
    for k in range(len(polygon)):
        a, b = beyond[k - 1], beyond[k]
        if (a > 0.0) != (b > 0.0):
            share = a / (a - b)
            corners.append(polygon[k - 1] + share * (polygon[k] - polygon[k - 1]))
        if b <= 0.0:
            corners.append(polygon[k])
    return np.array(corners).reshape(-1, 2)


def _chain(ordered: Iterable[Sequence[float]]) -> list[Sequence[float]]:
    """Return the corners of one half of a hull, of points sorted along it."""
    chain: list[Sequence[float]] = []
    for p in ordered:
        while len(chain) > 1 and _turn(chain[-2], chain[-1], p) <= SAME_POINT**2:
            chain.pop()
        chain.append(p)
    return chain


def _turn(a: Sequence[float], b: Sequence[float], c: Sequence[float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
