"""Bounds of the distance of two solids, and of their overlap, by gaps between parallel planes.

The planes touch the solids. The gap along any direction is a lower bound of the distance, and along the
direction of the two nearest points it is the distance. So a search that misses the nearest points yields a
looser bound, but never a wrong one.
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
GAP_TOLERANCE = 1e-5  # m between bound and distance at which the search may end
_MIN_LENGTH = 1e-9  # length below which a vector has no direction
_SPREADS = (0.3, 0.2, 0.1, 0.1, 0.05, 0.03, 0.02, 0.01)  # rad, around the best direction so far
_N_STARTS = 6  # directions from which the search for the best one begins: it ends in the nearest valley
_AROUND = np.array(list(product((-1.0, 0.0, 1.0), repeat=2)))


def gap(a: Shape, T_a: Array, b: Shape, T_b: Array, way: Array) -> float:
    """Return the width of the empty slab between two posed shapes along a direction.

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
    """Bound how deep two posed shapes overlap, and return the direction of least overlap.

    Moved apart by the overlap along any direction they no longer meet, so each overlap is an upper bound of
    the depth. The least is taken over ``ways`` and over the directions of faces, edges and round sides.

    Args:
        a: One shape.
        T_a: (4, 4) its pose.
        b: The other shape.
        T_b: (4, 4) its pose.
        ways: Directions (3,) to try.

    Returns:
        m, negative if a gap was found; (3,) unit direction from ``a`` to ``b``.
    """
    between, R_a, R_b = T_b[:3, 3] - T_a[:3, 3], T_a[:3, :3], T_b[:3, :3]
    radial = [between - T[:3, 2] * (T[:3, 2] @ between) for T in (T_a, T_b)]
    edges = np.cross(R_a.T[:, None], R_b.T).reshape(-1, 3)
    normals = [face_normals(shape) @ R.T for shape, R in ((a, R_a), (b, R_b))]
    directions = np.vstack([*ways, between, *radial, *normals, edges])
    lengths = np.linalg.norm(directions, axis=1)
    across = directions[lengths > _MIN_LENGTH] / lengths[lengths > _MIN_LENGTH, None]
    across = np.vstack([across, -across])

    def depths(ways: Array) -> Array:
        return half_widths(a, ways @ R_a) + half_widths(b, -ways @ R_b) - ways @ between

    found = depths(across)
    is_round = not {a.kind, b.kind} <= {ShapeKind.BOX, ShapeKind.HULL}
    starts = np.argsort(found, kind="stable")[: _N_STARTS if is_round else 1]
    best, least = across[starts], found[starts]
    for spread in _SPREADS if is_round else ():  # the least overlap of round solids may lie in between
        beside = np.array([perpendiculars(way) for way in best])
        around = best[:, None] + spread * (_AROUND @ beside)
        around /= np.linalg.norm(around, axis=2)[:, :, None]
        found = depths(around.reshape(-1, 3)).reshape(around.shape[:2])
        nearest = found.argmin(axis=1)
        lower, rows = found.min(axis=1), np.arange(len(best))
        best = np.where((lower < least)[:, None], around[rows, nearest], best)
        least = np.minimum(lower, least)
    first = int(np.argmin(least))
    return float(least[first]), best[first]


@lru_cache(maxsize=256)
def face_normals(shape: Shape) -> Array:
    """Return directions along which a shape separates soonest from another.

    Args:
        shape: The shape.

    Returns:
        (K, 3) unit directions in the shape's own frame: face normals, opposite ones once; its axes if it is
        round.
    """
    if shape.kind is not ShapeKind.HULL:
        return np.eye(3)
    return np.unique(ConvexHull(np.array(shape.vertices)).equations[:, :3].round(9), axis=0)


def half_widths(shape: Shape, directions: Array) -> Array:
    """Return the distances from a shape's centre to its supporting planes across several directions.

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
    """Return five lengths that give the half width of any shape in one formula.

    Along a unit direction (x, y, z) in the shape's own frame it is the sum of |x|, |y|, |z|, hypot(x, y) and
    1, each times its term; box, cylinder and sphere have different terms at 0. A hull has those of its
    bounding box, whose half width is not smaller.

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
    """Return lower bounds of the distances of many pairs of posed shapes.

    For each pair, the widest gap counts over the axes of both, their cross products (for boxes these decide
    whether the two meet: the separating axis theorem), and the line between the centres.

    Args:
        terms_a: (M, 5) of the first shapes, see ``half_width_terms``.
        T_a: (M, 4, 4) their poses in the world.
        terms_b: (M, 5) of the second shapes.
        T_b: (M, 4, 4) their poses in the world.

    Returns:
        (M,) m; negative if there is no gap.
    """
    R_a, R_b, between = T_a[:, :3, :3], T_b[:, :3, :3], T_b[:, :3, 3] - T_a[:, :3, 3]
    axes_a, axes_b = np.swapaxes(R_a, 1, 2), np.swapaxes(R_b, 1, 2)
    edges = np.cross(axes_a[:, :, None], axes_b[:, None]).reshape(-1, 9, 3)
    ways = np.concatenate([axes_a, axes_b, edges, between[:, None]], axis=1)
    lengths = np.sqrt(np.einsum("mkc,mkc->mk", ways, ways))
    is_way = lengths > _MIN_LENGTH
    across = ways / np.where(is_way, lengths, 1.0)[:, :, None]
    middles = np.abs(across @ between[:, :, None])[:, :, 0]
    widths = _half_widths_by(terms_a, across @ R_a) + _half_widths_by(terms_b, across @ R_b)
    return np.asarray(np.where(is_way, middles - widths, -np.inf).max(axis=1))


def _half_widths_by(terms: Array, directions: Array) -> Array:
    """Return half widths (..., K), m, by terms (..., 5), along unit directions (..., K, 3) in own frames."""
    flat = np.abs(directions) @ terms[..., :3, None]
    around = np.hypot(directions[..., 0], directions[..., 1])
    return np.asarray(flat[..., 0] + around * terms[..., 3, None] + terms[..., 4, None])


def support(shape: Shape, T: Array, direction: Array) -> Array:
    """Return the point of a posed shape that is farthest along a direction.

    Args:
        shape: The shape.
        T: (4, 4) its pose.
        direction: (3,) in the world, of any nonzero length.

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
    """Return the corners of a hull.

    Args:
        shape: The hull.

    Returns:
        (V, 3) m in its own frame.
    """
    return np.array(shape.vertices)


def separation(a: Shape, T_a: Array, b: Shape, T_b: Array) -> float:
    """Return a lower bound of the distance of two posed shapes.

    The shortest vector between them is the point nearest to 0 of all their differences b - a. It is found by
    Wolfe's algorithm (Finding the nearest point in a polytope, 1976; with corners from support functions it
    is Gilbert, Johnson and Keerthi's): of the corners seen so far it keeps those that span the face nearest
    to 0. Every step gives a direction, and the widest gap counts.

    Args:
        a: One shape.
        T_a: (4, 4) its pose.
        b: The other shape.
        T_b: (4, 4) its pose.

    Returns:
        m; 0 if they touch.
    """
    best = 0.0
    x = T_b[:3, 3] - T_a[:3, 3]
    corners, weights = x[None], np.ones(1)
    for _ in range(MAX_STEPS):
        length = math.sqrt(x @ x)
        if length <= best + GAP_TOLERANCE:
            break
        corner = support(b, T_b, -x) - support(a, T_a, x)
        best = max(best, float(corner @ x) / length)
        corners, weights = _nearest_to_zero(np.vstack([corners, corner]), np.append(weights, 0.0))
        x = weights @ corners
    return best


def _nearest_to_zero(corners: Array, weights: Array) -> tuple[Array, Array]:
    """Return the corners (K, 3) that span the point of their hull nearest to 0, and its weights (K,).

    weights: of the point of the hull at which the search starts; they sum up to 1
    """
    while True:
        aim = _of_plane(corners)
        if (aim > 0.0).all():
            return corners, aim
        shares = np.where(aim > 0.0, np.inf, weights / np.maximum(weights - aim, _MIN_LENGTH))
        first = int(np.argmin(shares))  # weight that vanishes first on the way to the aim
        weights = np.delete(weights + shares[first] * (aim - weights), first)
        corners = np.delete(corners, first, axis=0)


def _of_plane(corners: Array) -> Array:
    """Return weights (K,), of any sign, of the point nearest to 0 in the affine hull of corners."""
    edges = corners[1:] - corners[0]
    rest = np.linalg.lstsq(edges.T, -corners[0], rcond=None)[0]
    return np.append(1.0 - rest.sum(), rest)
