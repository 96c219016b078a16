"""How far apart two solids are at least, how deep they overlap at most: the gap between two parallel planes
that touch them.

Across any direction whatsoever that gap is a true lower bound of the distance, and across the direction
of the two nearest points it is the distance. So a search that misses the nearest points costs tightness,
never truth.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array

MAX_PROJECTIONS = 200
TIGHT = 1e-5  # m, between bound and distance, where the search may end
_NO_WAY = 1e-9  # length of what is no direction any more


def gap(a: Shape, T_a: Array, b: Shape, T_b: Array, way: Array) -> float:
    """Width in m of the empty slab between two posed shapes across ``way`` (3,); negative without one."""
    length = math.sqrt(way @ way)
    if length == 0.0:
        return -math.inf
    across = way / length
    middle = float(across @ (T_b[:3, 3] - T_a[:3, 3]))
    return middle - half_width(a, T_a, across) - half_width(b, T_b, across)


def overlap(a: Shape, T_a: Array, b: Shape, T_b: Array, ways: Sequence[Array]) -> float:
    """How deep in m two posed shapes that meet overlap, at most.

    Pushed apart by the overlap across any direction they no longer meet, so each is an upper bound of the
    depth. The least counts: of ``ways`` (3,), and of those in which what is flat or round gives way first.
    """
    between, R_a, R_b = T_b[:3, 3] - T_a[:3, 3], T_a[:3, :3], T_b[:3, :3]
    radial = [between - T[:3, 2] * (T[:3, 2] @ between) for T in (T_a, T_b)]
    edges = np.cross(R_a.T[:, None], R_b.T).reshape(-1, 3)
    directions = np.vstack([*ways, between, *radial, R_a.T, R_b.T, edges])
    lengths = np.linalg.norm(directions, axis=1)
    across = directions[lengths > _NO_WAY] / lengths[lengths > _NO_WAY, None]
    together = half_widths(a, across @ R_a) + half_widths(b, across @ R_b)
    return float((together - np.abs(across @ between)).min())


def half_widths(shape: Shape, directions: Array) -> Array:
    """(K,): ``half_width`` for unit directions (K, 3) in the shape's own frame."""
    x, y, z = np.abs(directions).T
    size = shape.size
    if shape.kind is ShapeKind.BOX:
        return np.asarray((x * size[0] + y * size[1] + z * size[2]) / 2)
    if shape.kind is ShapeKind.SPHERE:
        return np.full(len(x), size[0])
    return np.asarray(size[0] * np.hypot(x, y) + z * size[1] / 2)


def half_width(shape: Shape, T: Array, direction: Array) -> float:
    """From the shape's centre to the farthest plane across a unit direction (3,) that touches it, m."""
    x, y, z = (float(c) for c in direction @ T[:3, :3])
    size = shape.size
    if shape.kind is ShapeKind.BOX:
        return (abs(x) * size[0] + abs(y) * size[1] + abs(z) * size[2]) / 2
    if shape.kind is ShapeKind.SPHERE:
        return size[0]
    return size[0] * math.hypot(x, y) + abs(z) * size[1] / 2


def nearest_point(shape: Shape, T: Array, x: Array) -> Array:
    """The point (3,) of a posed shape that is nearest to a point (3,), both in the world."""
    local = T[:3, :3].T @ (x - T[:3, 3])
    if shape.kind is ShapeKind.BOX:
        half = np.array(shape.size) / 2
        local = np.clip(local, -half, half)
    elif shape.kind is ShapeKind.SPHERE:
        local = local * _shrink(shape.size[0], float(np.linalg.norm(local)))
    else:
        local[:2] *= _shrink(shape.size[0], math.hypot(*local[:2]))
        local[2] = np.clip(local[2], -shape.size[1] / 2, shape.size[1] / 2)
    return np.asarray(T[:3, :3] @ local + T[:3, 3])


def _shrink(radius: float, r: float) -> float:
    return radius / r if r > radius else 1.0


def separation(a: Shape, T_a: Array, b: Shape, T_b: Array) -> float:
    """The distance in m of two posed shapes from below; 0 where they touch.

    Alternating projections between two convex sets approach their nearest points (Cheney and Goldstein);
    every step gives a direction, and the widest gap counts.
    """
    best, x = 0.0, T_b[:3, 3]
    for _ in range(MAX_PROJECTIONS):
        p = nearest_point(a, T_a, x)
        x = nearest_point(b, T_b, p)
        best = max(best, gap(a, T_a, b, T_b, x - p))
        if math.dist(p, x) <= best + TIGHT:
            break
    return best
