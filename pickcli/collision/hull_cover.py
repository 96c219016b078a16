"""Spheres that contain a union of convex polyhedra, the pieces of a link's meshes. Proof: ``sphere_cover``.

Every piece is cut into small cells by planes across the axes; each cell is convex, so a ball that contains
its corners contains it. The choice of balls is a set cover problem. The depth of a centre is the largest over
the pieces: no ball reaches farther out of that piece, let alone of the union, than its radius minus the
depth.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from pickcli.collision.set_cover import CoverProblem, solve_greedily
from pickcli.collision.solid_covers import Spheres
from pickcli.geometry import Array

MAX_CELLS = 1400  # of all pieces together: the work grows with the square
_FINENESS = 0.8  # width of a cell against the excess
_GROWTH = 1.1  # factor of the excess while there are too many spheres
_BATCH = 2_000_000  # distances per batch


def cover_hulls(pieces: Sequence[Array], excess: float, max_excess: float, max_count: int) -> Spheres:
    """Cover convex polyhedra with spheres.

    Args:
        pieces: The corners (V, 3) of each polyhedron, m, in one frame.
        excess: m, how far the spheres may stick out if they are few enough.
        max_excess: m, how far they may stick out at most, for any number; more if the solid is too large.
        max_count: Most spheres, if ``max_excess`` allows it.

    Returns:
        The spheres, in that frame.
    """
    volume = sum(float(ConvexHull(piece).volume) for piece in pieces)
    width = max(_FINENESS * excess, float(np.cbrt(volume / MAX_CELLS)))
    cells = [cell for piece in pieces for cell in _cells(piece, width)]
    centers = np.array([cell.mean(axis=0) for cell in cells])
    problem = CoverProblem(depths(pieces, centers), np.ones(len(centers)), _farthest(centers, cells))
    while True:
        solution = solve_greedily(problem, excess)
        if solution is not None and (len(solution[0]) <= max_count or excess >= max_excess):
            return centers[solution[0]], solution[1]
        excess = excess * _GROWTH if solution is None else min(excess * _GROWTH, max_excess)


def depths(pieces: Sequence[Array], points: Array) -> Array:
    """Return lower bounds of how deep points lie in a union of convex polyhedra.

    Args:
        pieces: The corners (V, 3) of each polyhedron, m.
        points: (N, 3) m.

    Returns:
        (N,) m from the surface of the piece that each point is deepest in; negative outside of all.
    """
    planes = [ConvexHull(piece).equations for piece in pieces]
    return np.asarray(np.max([-(points @ p[:, :3].T + p[:, 3]).max(axis=1) for p in planes], axis=0))


def _cells(piece: Array, width: float) -> list[Array]:
    """Cut a polyhedron by planes across all three axes; return the corners (V, 3) of each part."""
    parts = [piece]
    for axis in range(3):
        low, high = piece[:, axis].min(), piece[:, axis].max()
        bounds = np.linspace(low, high, int(np.ceil((high - low) / width)) + 1)
        parts = [slab for part in parts for slab in _slabs(part, axis, bounds)]
    return parts


def _slabs(part: Array, axis: int, bounds: Array) -> list[Array]:
    """Cut a polyhedron by planes across one axis."""
    corners, edges = _skeleton(part)
    start, end = corners[edges[:, 0]], corners[edges[:, 1]]
    found = []
    for low, high in pairwise(bounds):
        inside = corners[(corners[:, axis] >= low) & (corners[:, axis] <= high)]
        slab = np.vstack([inside, *(_crossings(start, end, axis, at) for at in (low, high))])
        if len(slab):
            found.append(slab)
    return found


def _crossings(start: Array, end: Array, axis: int, at: float) -> Array:
    """Return (K, 3) intersections of edges with a plane across an axis."""
    before, after = start[:, axis] - at, end[:, axis] - at
    crosses = before * after < 0.0
    share = (before[crosses] / (before[crosses] - after[crosses]))[:, None]
    return np.asarray(start[crosses] + share * (end[crosses] - start[crosses]))


def _skeleton(points: Array) -> tuple[Array, Array]:
    """Return corners (V, 3) and edges (E, 2) of the hull of points; all pairs if it is flat."""
    try:
        hull = ConvexHull(points) if len(points) > 3 else None
    except QhullError:
        hull = None
    if hull is None:
        return points, np.column_stack(np.triu_indices(len(points), 1))
    sides = hull.simplices[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    return points, np.unique(np.sort(sides, axis=1), axis=0)


def _farthest(centers: Array, cells: Sequence[Array]) -> Array:
    """Return (K, C) m from each centre to the farthest corner of each cell."""
    corners, first = np.concatenate(cells), np.cumsum([0, *(len(cell) for cell in cells[:-1])])
    squares = (corners**2).sum(axis=1)
    rows = max(1, _BATCH // len(corners))
    found = [
        np.maximum.reduceat(squares - 2.0 * block @ corners.T, first, axis=1)
        + (block**2).sum(axis=1)[:, None]
        for block in (centers[k : k + rows] for k in range(0, len(centers), rows))
    ]
    return np.asarray(np.sqrt(np.maximum(np.concatenate(found), 0.0)))
