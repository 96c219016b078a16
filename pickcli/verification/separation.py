"""Bounds on how far apart two solids are, and how deep they overlap: the gap between two parallel planes.

The planes touch the solids. Across any direction whatsoever that gap is a true lower bound of the distance,
and across the direction of the two nearest points it is the distance. So a search that misses the nearest
points costs tightness, never truth.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import product

import numpy as np
from scipy.spatial import ConvexHull

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, perpendiculars

MAX_STEPS = 200
TIGHT = 1e-5  # m, between bound and distance, where the search may end
_NO_WAY = 1e-9  # length of what is no direction any more
_SPREADS = (0.3, 0.2, 0.1, 0.1, 0.05, 0.03, 0.02, 0.01)  # rad, around the best direction so far
_AROUND = np.array(list(product((-1.0, 0.0, 1.0), repeat=2)))


def gap(a: Shape, T_a: Array, b: Shape, T_b: Array, way: Array) -> float:
    """Width of the empty slab between two posed shapes across a direction.

    Args:
        a: One shape.
        T_a: (4, 4) its pose.
        b: The other shape.
        T_b: (4, 4) its pose.
        way: (3,) direction.

    Returns:
        m; negative without a gap.
    """
    length = math.sqrt(way @ way)
    if length == 0.0:
        return -math.inf
    across = way / length
    return float((support(b, T_b, -across) - support(a, T_a, across)) @ across)


def overlap(a: Shape, T_a: Array, b: Shape, T_b: Array, ways: Sequence[Array] = ()) -> tuple[float, Array]:
    """How deep two posed shapes that meet overlap, at most, and across which direction.

    Pushed apart by the overlap across any direction they no longer meet, so each is an upper bound of the
    depth. The least counts: of ``ways``, and of those in which what is flat or round gives way first.

    Args:
        a: One shape.
        T_a: (4, 4) its pose.
        b: The other shape.
        T_b: (4, 4) its pose.
        ways: Directions (3,) to try.

    Returns:
        m, negative where a gap was found; (3,) unit direction from ``a`` to ``b``.
    """
    between, R_a, R_b = T_b[:3, 3] - T_a[:3, 3], T_a[:3, :3], T_b[:3, :3]
    radial = [between - T[:3, 2] * (T[:3, 2] @ between) for T in (T_a, T_b)]
    edges = np.cross(R_a.T[:, None], R_b.T).reshape(-1, 3)
    normals = [face_normals(shape) @ R.T for shape, R in ((a, R_a), (b, R_b))]
    directions = np.vstack([*ways, between, *radial, *normals, edges])
    lengths = np.linalg.norm(directions, axis=1)
    across = directions[lengths > _NO_WAY] / lengths[lengths > _NO_WAY, None]
    across = np.vstack([across, -across])

    def depths(ways: Array) -> Array:
        return half_widths(a, ways @ R_a) + half_widths(b, -ways @ R_b) - ways @ between

    found = depths(across)
    best, least = across[int(np.argmin(found))], float(found.min())
    is_round = not {a.kind, b.kind} <= {ShapeKind.BOX, ShapeKind.HULL}
    for spread in _SPREADS if is_round else ():  # round solids may part in a direction that is neither's
        around = best + spread * (_AROUND @ np.array(perpendiculars(best)))
        around /= np.linalg.norm(around, axis=1)[:, None]
        found = depths(around)
        if found.min() < least:
            best, least = around[int(np.argmin(found))], float(found.min())
    return least, best


@lru_cache(maxsize=256)
def face_normals(shape: Shape) -> Array:
    """Directions in which a shape that is pushed along them leaves another soonest.

    Args:
        shape: The shape.

    Returns:
        (K, 3) unit directions in the shape's own frame: normals of its faces, opposite ones once; its axes
        where it is round.
    """
    if shape.kind is not ShapeKind.HULL:
        return np.eye(3)
    return np.unique(ConvexHull(np.array(shape.vertices)).equations[:, :3].round(9), axis=0)


def half_widths(shape: Shape, directions: Array) -> Array:
    """From a shape's centre to the planes across several directions that touch it there.

    Args:
        shape: The shape.
        directions: (K, 3) unit directions in the shape's own frame.

    Returns:
        (K,) m.
    """
    if shape.kind is ShapeKind.HULL:
        return np.asarray((directions @ corners(shape).T).max(axis=1))
    return _half_widths_by(half_width_terms(shape), directions)


def half_width_terms(shape: Shape) -> Array:
    """Five lengths that say the half width of any shape in one formula.

    Across a unit direction (x, y, z) in the shape's own frame it is the sum of |x|, |y|, |z|, hypot(x, y) and
    1, each times its term: box, cylinder and sphere differ in what is 0. Of a hull they are those of the box
    around it, which is no less wide.

    Args:
        shape: The shape.

    Returns:
        (5,) m.
    """
    size = shape.size
    if shape.kind in (ShapeKind.BOX, ShapeKind.HULL):
        return np.array([size[0] / 2, size[1] / 2, size[2] / 2, 0.0, 0.0])
    if shape.kind is ShapeKind.SPHERE:
        return np.array([0.0, 0.0, 0.0, 0.0, size[0]])
    return np.array([0.0, 0.0, size[1] / 2, size[0], 0.0])


def widest_gaps(terms_a: Array, T_a: Array, terms_b: Array, T_b: Array) -> Array:
    """Lower bounds of the distances of many pairs of posed shapes.

    Of each pair the widest gap counts across the axes of both, the products of these (for boxes these tell
    whether the two meet: the separating axis theorem), and the line between the centres.

    Args:
        terms_a: (M, 5) of the first shapes, see ``half_width_terms``.
        T_a: (M, 4, 4) their poses in the world.
        terms_b: (M, 5) of the second shapes.
        T_b: (M, 4, 4) their poses in the world.

    Returns:
        (M,) m; negative where there is no gap.
    """
    R_a, R_b, between = T_a[:, :3, :3], T_b[:, :3, :3], T_b[:, :3, 3] - T_a[:, :3, 3]
    axes_a, axes_b = np.swapaxes(R_a, 1, 2), np.swapaxes(R_b, 1, 2)
    edges = np.cross(axes_a[:, :, None], axes_b[:, None]).reshape(-1, 9, 3)
    ways = np.concatenate([axes_a, axes_b, edges, between[:, None]], axis=1)
    lengths = np.sqrt(np.einsum("mkc,mkc->mk", ways, ways))
    is_way = lengths > _NO_WAY
    across = ways / np.where(is_way, lengths, 1.0)[:, :, None]
    middles = np.abs(across @ between[:, :, None])[:, :, 0]
    widths = _half_widths_by(terms_a, across @ R_a) + _half_widths_by(terms_b, across @ R_b)
    return np.asarray(np.where(is_way, middles - widths, -np.inf).max(axis=1))


def _half_widths_by(terms: Array, directions: Array) -> Array:
    """(..., K) m by the terms (..., 5) of shapes, across unit directions (..., K, 3) in their own frames."""
    flat = np.abs(directions) @ terms[..., :3, None]
    around = np.hypot(directions[..., 0], directions[..., 1])
    return np.asarray(flat[..., 0] + around * terms[..., 3, None] + terms[..., 4, None])


def support(shape: Shape, T: Array, direction: Array) -> Array:
    """The point of a posed shape that is farthest along a direction.

    Args:
        shape: The shape.
        T: (4, 4) its pose.
        direction: (3,) in the world, of any length but 0.

    Returns:
        (3,) m in the world.
    """
    local = direction @ T[:3, :3]
    size = shape.size
    if shape.kind is ShapeKind.BOX:
        point = np.copysign(np.array(size) / 2, local)
    elif shape.kind is ShapeKind.HULL:
        point = corners(shape)[np.argmax(corners(shape) @ local)]
    elif shape.kind is ShapeKind.SPHERE:
        point = local * (size[0] / math.sqrt(local @ local))
    else:
        around = math.atan2(local[1], local[0])
        point = np.array(
            [size[0] * math.cos(around), size[0] * math.sin(around), math.copysign(size[1] / 2, local[2])]
        )
    return np.asarray(T[:3, :3] @ point + T[:3, 3])


@lru_cache(maxsize=256)
def corners(shape: Shape) -> Array:
    """The corners of a hull.

    Args:
        shape: The hull.

    Returns:
        (V, 3) m in its own frame.
    """
    return np.array(shape.vertices)


def separation(a: Shape, T_a: Array, b: Shape, T_b: Array) -> float:
    """The distance of two posed shapes from below.

    The least vector from one to the other is the point nearest to 0 of all their differences b - a, which
    Wolfe's algorithm finds (Finding the nearest point in a polytope, 1976; with the corners that support
    functions give it is Gilbert, Johnson and Keerthi's): of the corners seen so far it keeps those that span
    the face next to 0. Every step gives a direction, and the widest gap counts.

    Args:
        a: One shape.
        T_a: (4, 4) its pose.
        b: The other shape.
        T_b: (4, 4) its pose.

    Returns:
        m; 0 where they touch.
    """
    best = 0.0
    x = T_b[:3, 3] - T_a[:3, 3]
    corners, weights = x[None], np.ones(1)
    for _ in range(MAX_STEPS):
        length = math.sqrt(x @ x)
        if length <= best + TIGHT:
            break
        corner = support(b, T_b, -x) - support(a, T_a, x)
        best = max(best, float(corner @ x) / length)
        corners, weights = _nearest_to_zero(np.vstack([corners, corner]), np.append(weights, 0.0))
        x = weights @ corners
    return best


def _nearest_to_zero(corners: Array, weights: Array) -> tuple[Array, Array]:
    """The corners (K, 3) that the point of their hull nearest to 0 lies between, and its weights (K,).

    weights: of a point of the hull where the search starts; they sum up to 1
    """
    while True:
        aim = _of_plane(corners)
        if (aim > 0.0).all():
            return corners, aim
        shares = np.where(aim > 0.0, np.inf, weights / np.maximum(weights - aim, _NO_WAY))
        first = int(np.argmin(shares))  # of the weights to vanish on the way to the aim
        weights = np.delete(weights + shares[first] * (aim - weights), first)
        corners = np.delete(corners, first, axis=0)


def _of_plane(corners: Array) -> Array:
    """Weights (K,), of any sign, of the point nearest to 0 in the point, line, plane or space of corners."""
    edges = corners[1:] - corners[0]
    rest = np.linalg.lstsq(edges.T, -corners[0], rcond=None)[0]
    return np.append(1.0 - rest.sum(), rest)
