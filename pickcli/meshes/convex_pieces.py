"""Convex polyhedra that contain a mesh: its hull, or hulls of parts if their total volume is much smaller.

A mesh is cut by planes, each at the position that saves most volume, and every part is replaced by the hull
of its triangles. Triangles that cross a plane are split, so each piece of the surface is in the hull of its
part: the pieces contain the whole surface for any mesh (closed or not) and any cuts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from pickcli.geometry import Array

MAX_PIECES = 8
LEAST_SAVED = 0.05  # share of the hull's volume that another piece must save
LEAST_VOLUME = 2e-5  # m^3 that another piece must save: a cube of 27 mm
_PLACES = np.linspace(0.1, 0.9, 9)  # relative positions of candidate planes along each side of a box


@dataclass(frozen=True, eq=False)
class _Part:
    """Triangles of a mesh, with the plane that divides them best.

    Attributes:
        triangles: (T, 3, 3) m.
        axis: Axis of the mesh's frame normal to the plane.
        at: m, position of the plane on the axis.
        saved: m^3, volume of the whole hull minus that of both sides' hulls.
    """

    triangles: Array
    axis: int
    at: float
    saved: float


def convex_pieces(triangles: Array) -> tuple[Array, ...]:
    """Find a few convex polyhedra that contain a mesh.

    Args:
        triangles: (T, 3, 3) m, corners of the mesh's triangles.

    Returns:
        The corners (V, 3) of each polyhedron, in m in the frame of the mesh.

    Raises:
        ValueError: The mesh is flat.
    """
    whole = _volume(triangles.reshape(-1, 3))
    if whole == 0.0:
        raise ValueError("is flat; give it a thickness")
    least = max(LEAST_SAVED * whole, LEAST_VOLUME)
    parts = [_part(triangles, least)]
    while len(parts) < MAX_PIECES:
        k = int(np.argmax([part.saved for part in parts]))
        if parts[k].saved < least:
            break
        halves = _halves(parts[k].triangles, parts[k].axis, parts[k].at)
        parts[k : k + 1] = [_part(half, least) for half in halves]
    return tuple(_corners(part.triangles) for part in parts)


def _part(triangles: Array, least: float) -> _Part:
    """Find the best plane of a part, unless its whole volume is less than what must be saved."""
    points = triangles.reshape(-1, 3)
    whole = _volume(points)
    best = _Part(triangles, 0, 0.0, 0.0)
    if whole < least:
        return best
    low, high = points.min(axis=0), points.max(axis=0)
    for axis in range(3):
        for at in low[axis] + _PLACES * (high[axis] - low[axis]):
            volumes = [_volume(side) for side in _clipped_points(triangles, axis, at)]
            saved = whole - sum(volumes)
            if min(volumes) > 0.0 and saved > best.saved:
                best = _Part(triangles, axis, float(at), saved)
    return best


def _clipped_points(triangles: Array, axis: int, at: float) -> tuple[Array, Array]:
    """Corners (P, 3) of the triangles below and above a plane, including intersections with it."""
    start, end = triangles.reshape(-1, 3), np.roll(triangles, -1, axis=1).reshape(-1, 3)
    before, after = start[:, axis] - at, end[:, axis] - at
    crosses = before * after < 0.0
    share = (before[crosses] / (before[crosses] - after[crosses]))[:, None]
    on_plane = start[crosses] + share * (end[crosses] - start[crosses])
    return np.vstack([start[before <= 0.0], on_plane]), np.vstack([start[before >= 0.0], on_plane])


def _halves(triangles: Array, axis: int, at: float) -> tuple[Array, Array]:
    """Triangles (T, 3, 3) below and above a plane; triangles that cross it are split."""
    below: list[Array] = []
    above: list[Array] = []
    heights = triangles[:, :, axis] - at
    for triangle, height in zip(triangles, heights, strict=True):
        if (height <= 0.0).all():
            below.append(triangle[None])
        elif (height >= 0.0).all():
            above.append(triangle[None])
        else:
            below.append(_fan(_clipped(triangle, -height)))
            above.append(_fan(_clipped(triangle, height)))
    return np.concatenate(below), np.concatenate(above)


def _clipped(triangle: Array, height: Array) -> Array:
    """Ordered corners (3 or 4, 3) of the part of a triangle with nonnegative height."""
    corners = []
    for i, j in ((0, 1), (1, 2), (2, 0)):
        if height[i] >= 0.0:
            corners.append(triangle[i])
        if height[i] * height[j] < 0.0:
            corners.append(triangle[i] + height[i] / (height[i] - height[j]) * (triangle[j] - triangle[i]))
    return np.array(corners)


def _fan(corners: Array) -> Array:
    """Triangles (K - 2, 3, 3) of a convex polygon (K, 3)."""
    return np.array([[corners[0], corners[k], corners[k + 1]] for k in range(1, len(corners) - 1)])


def _volume(points: Array) -> float:
    """Volume of the hull of points (P, 3), m^3; 0 if they are coplanar."""
    if len(points) < 4:
        return 0.0
    try:
        return float(ConvexHull(points).volume)
    except QhullError:
        return 0.0


def _corners(triangles: Array) -> Array:
    points = triangles.reshape(-1, 3)
    return np.asarray(points[ConvexHull(points).vertices])
