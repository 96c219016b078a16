"""Sphere covers of one solid within a given excess: box, cylinder, capsule. Proof: ``sphere_cover``."""

from __future__ import annotations

from itertools import product
from typing import TypeAlias

import numpy as np

from pickcli.collision.set_cover import CoverProblem, solve_greedily
from pickcli.geometry import Array

# Possible numbers of copies around the axis of a sphere off a cylinder's axis.
_FOLDS = (3, 4, 5, 6, 8, 10, 12, 16, 24, 32, 48, 64)

# Width of the cells relative to a sphere's reach on a flat face. None is best for all shapes: the fewest
# wins.
_FINENESS = (0.4, 0.25)

# Candidates times cells beyond which a greedy cover takes too long: the excess must grow instead.
_MOST_PAIRS = 800_000

Spheres: TypeAlias = tuple[Array, Array]  # centres (S, 3) and radii (S,)


def cover_box(extents: Array, excess: float) -> Spheres | None:
    """Cover a box with spheres.

    Flat boxes are covered best by one layer of spheres, thick ones greedily in one octant and mirrored.

    Args:
        extents: (3,) m, full lengths of the edges.
        excess: m, how far the spheres may stick out.

    Returns:
        The spheres, in the frame of the box; None if they would be too many.
    """
    half = extents / 2
    candidates = [_cover_layer(half, excess), *(_cover_octants(half, excess, f) for f in _FINENESS)]
    return _fewest(candidates)


def cover_cylinder(radius: float, length: float, excess: float) -> Spheres | None:
    """Cover a cylinder about z with spheres.

    The cells are whole rings (a rectangle in (rho, z) turned about the axis), mirrored in z. A candidate off
    the axis stands for n copies turned by 2 pi / n, each of which covers its sector of the ring. A thin
    cylinder is covered equally well by a column of equal spheres on its axis.

    Args:
        radius: m.
        length: m.
        excess: m, how far the spheres may stick out.

    Returns:
        The spheres, in the frame of the cylinder; None if they would be too many.
    """
    column = _cover_column(radius, length / 2, excess)
    return _fewest([column, *(_cover_rings(radius, length / 2, excess, f) for f in _FINENESS)])


def cover_capsule(radius: float, length: float, excess: float) -> Spheres:
    """Cover a cylinder about z and the balls at its ends with the fewest equal spheres on the axis.

    Spheres whose centres are s apart meet in a circle of radius sqrt(r^2 - (s/2)^2), which must not be less
    than the capsule's radius.

    Args:
        radius: m.
        length: m, between the centres of the balls.
        excess: m, how far the spheres may stick out.

    Returns:
        The spheres, in the frame of the cylinder.
    """
    widest = 2 * np.sqrt((radius + excess) ** 2 - radius**2)
    n = int(np.ceil(length / widest)) + 1
    z = np.linspace(-length / 2, length / 2, n)
    return np.column_stack([np.zeros((n, 2)), z]), np.full(n, np.hypot(radius, length / (n - 1) / 2))


def _cover_octants(half: Array, excess: float, fineness: float) -> Spheres | None:
    grids = [_grid(float(h), _cell_width(float(half.min()), excess, fineness)) for h in half]
    if np.prod([len(grid) - 1 for grid in grids]) ** 2 > _MOST_PAIRS:
        return None
    centers = np.array(list(product(*(grid[:-1] for grid in grids))))
    x, y, z = (_span_squared(grid[:-1], grid) for grid in grids)
    squared = x[:, None, None, :, None, None] + y[:, None, None, :, None] + z[:, None, None, :]
    farthest = np.sqrt(squared).reshape(len(centers), -1)
    images = 2.0 ** (centers > 0).sum(axis=1)
    solution = solve_greedily(CoverProblem((half - centers).min(axis=1), images, farthest), excess)
    if solution is None:
        return None
    return _stack([_mirrored(centers[k], float(radius)) for k, radius in zip(*solution, strict=True)])


def _cover_column(radius: float, half: float, excess: float) -> Spheres | None:
    """Place equal spheres on the axis, each around its slice; None if they stick out too far at the ends."""
    n = int(np.ceil(half / np.sqrt((radius + excess) ** 2 - radius**2)))
    reach = float(np.hypot(radius, half / n))
    if reach - half / n > excess:
        return None
    return np.column_stack([np.zeros((n, 2)), _middles(half, n)]), np.full(n, reach)


def _cover_rings(radius: float, half: float, excess: float, fineness: float) -> Spheres | None:
    width = _cell_width(min(radius, half), excess, fineness)
    r, z = _grid(radius, width), _grid(half, width)
    rings = np.array([(0.0, h, 1.0) for h in z[:-1]] + [*product(r[1:-1], z[:-1], _FOLDS)])
    if len(rings) * (len(r) - 1) * (len(z) - 1) > _MOST_PAIRS:
        return None
    rho, height, folds = rings.T
    far_rho = np.maximum(_chord_squared(rho, folds, r[:-1]), _chord_squared(rho, folds, r[1:]))
    farthest = np.sqrt(far_rho[:, :, None] + _span_squared(height, z)[:, None, :]).reshape(len(rings), -1)
    images = folds * np.where(height > 0, 2, 1)
    solution = solve_greedily(CoverProblem(np.minimum(radius - rho, half - height), images, farthest), excess)
    if solution is None:
        return None
    return _stack([_turned(rings[k], float(reach)) for k, reach in zip(*solution, strict=True)])


def _fewest(candidates: list[Spheres | None]) -> Spheres | None:
    return min((c for c in candidates if c is not None), key=lambda c: len(c[1]), default=None)


def _cell_width(thinnest: float, excess: float, fineness: float) -> float:
    """Return a cell width small enough to cover every edge and corner, and fine relative to a sphere's reach.

    A sphere at depth w below the faces of a corner reaches it if sqrt(3) w <= w + excess, so w up to
    1.366 excess; on a flat face a sphere at depth d covers a disc of radius sqrt(excess (2 d + excess)).
    """
    return min(1.36 * excess, fineness * float(np.sqrt(excess * (2 * thinnest + excess))))


def _grid(half: float, width: float) -> Array:
    """Return bounds of equal cells over [0, half], none wider than ``width``. Centres are on lower bounds."""
    return np.linspace(0.0, half, int(np.ceil(half / width)) + 1)


def _span_squared(centers: Array, grid: Array) -> Array:
    """Return (K, C) squared distances along one axis to the far end of each cell."""
    return np.maximum((centers[:, None] - grid[:-1]) ** 2, (centers[:, None] - grid[1:]) ** 2)


def _chord_squared(rho: Array, folds: Array, edge: Array) -> Array:
    """Return (K, C) squared distances in the plane from (rho, angle 0) to the ends of arcs (radius ``edge``).

    The arc spans +-pi / folds. For rho = 0 (one sphere on the axis) all angles are equally far.
    """
    cosine = np.cos(np.pi / folds)[:, None]
    return rho[:, None] ** 2 + edge**2 - 2 * rho[:, None] * edge * cosine


def _cover_layer(half: Array, excess: float) -> Spheres | None:
    """Place one layer of equal spheres in the middle of the box, each around its cell of a rectangular grid.

    None if the cells are so narrow that the spheres stick out of the box's sides.
    """
    order = np.argsort(half, kind="stable")
    thin, a, b = half[order]
    # Half diagonal that a cell may have across the layer, for a sphere of radius thin + excess.
    rho = np.sqrt((thin + excess) ** 2 - thin**2)
    fewest = int(np.floor(a / rho)) + 1
    rows = [(n, int(np.ceil(b / np.sqrt(rho**2 - (a / n) ** 2)))) for n in range(fewest, 2 * fewest + 2)]
    n, m = min(rows, key=lambda row: row[0] * row[1])
    radius = float(np.sqrt(thin**2 + (a / n) ** 2 + (b / m) ** 2))
    if radius - min(a / n, b / m) > excess:
        return None
    centers = np.zeros((n * m, 3))
    centers[:, order[1:]] = list(product(_middles(a, n), _middles(b, m)))
    return centers, np.full(n * m, radius)


def _middles(half: float, n: int) -> Array:
    return np.asarray((2 * np.arange(n) + 1 - n) * (half / n), dtype=np.float64)


def _mirrored(center: Array, radius: float) -> Array:
    signs = np.array(list(product(*((1, -1) if c > 0 else (1,) for c in center))))
    return np.column_stack([signs * center, np.full(len(signs), radius)])


def _turned(ring: Array, radius: float) -> Array:
    rho, z, folds = ring
    angles = 2 * np.pi * np.arange(int(folds)) / folds
    levels = (z, -z) if z > 0 else (z,)
    return np.array([(rho * np.cos(a), rho * np.sin(a), h, radius) for h in levels for a in angles])


def _stack(parts: list[Array]) -> Spheres:
    centers, radii = np.split(np.concatenate(parts), [3], axis=1)
    return centers, radii[:, 0]
