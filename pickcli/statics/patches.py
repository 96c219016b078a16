"""Contact patches: areas in which faces, edges or corners of two solids meet."""

from __future__ import annotations

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, perpendiculars

N_RIM_POINTS = 16  # points that approximate the rim of a cylinder's end
_POINT_TOLERANCE = 1e-9  # m


def feature(shape: Shape, T: Array, direction: Array, tolerance: float) -> Array:
    """Return the outermost face, edge or corner of a solid in a direction, as points in the world.

    Args:
        shape: Box, cylinder or sphere.
        T: (4, 4) pose of the shape.
        direction: (3,) unit vector in the world.
        tolerance: rad by which a face or an edge may deviate from perpendicular to the direction.

    Returns:
        (K, 3) m: corners of a face, ends of an edge or of a cylinder's contact line, or a point.
    """
    local = T[:3, :3].T @ direction
    flat = float(np.sin(tolerance))
    if shape.kind is ShapeKind.SPHERE:
        points = (local * shape.size[0])[None]
    elif shape.kind is ShapeKind.BOX:
        sides = [(-1.0, 1.0) if abs(c) <= flat else (float(np.copysign(1.0, c)),) for c in local]
        points = (
            np.array([(x, y, z) for x in sides[0] for y in sides[1] for z in sides[2]]) * shape.extents / 2
        )
    else:
        points = _of_cylinder(shape, local, flat)
    return np.asarray(points @ T[:3, :3].T + T[:3, 3])


def _of_cylinder(shape: Shape, local: Array, flat: float) -> Array:
    radius, length = shape.size
    across, end = float(np.hypot(local[0], local[1])), float(np.copysign(length / 2, local[2]))
    if across <= flat:
        turns = 2 * np.pi * np.arange(N_RIM_POINTS) / N_RIM_POINTS
        return np.column_stack([radius * np.cos(turns), radius * np.sin(turns), np.full(N_RIM_POINTS, end)])
    x, y = local[:2] * (radius / across)
    ends = (-length / 2, length / 2) if abs(local[2]) <= flat else (end,)
    return np.array([(x, y, z) for z in ends])


def patch(carried: Array, carrier: Array, normal: Array, inset: float) -> Array:
    """Compute the patch in which two features press on each other.

    Args:
        carried: (K, 3) points of the upper feature.
        carrier: (M, 3) points of the lower feature.
        normal: (3,) unit contact normal.
        inset: m by which every side of the carrier's face is moved inwards, for uncertain poses.

    Returns:
        (N, 3) corners of the patch, at the height of ``carrier``; (0, 3) if the features do not meet.
    """
    basis = np.column_stack(perpendiculars(normal))
    mine, theirs = _hull(carried @ basis), _hull(carrier @ basis)
    if len(theirs) >= 3:
        met = _clipped(mine, theirs, inset)
    elif len(mine) >= 3:
        met = _clipped(theirs, mine, 0.0)
    else:
        met = _crossing(mine, theirs)
    return np.asarray(met @ basis.T + float((carrier @ normal).max()) * normal)


def _hull(points: Array) -> Array:
    """Corners (K, 2) of the convex hull, counterclockwise (Andrew's monotone chain)."""
    order = sorted({(round(x, 9), round(y, 9)) for x, y in points.tolist()})
    if len(order) <= 2:
        return np.array(order)
    halves = []
    for run in (order, order[::-1]):
        half: list[tuple[float, float]] = []
        for p in run:
            while len(half) >= 2 and _turn(half[-2], half[-1], p) <= _POINT_TOLERANCE**2:
                half.pop()
            half.append(p)
        halves.append(half[:-1])
    return np.array(halves[0] + halves[1])


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _clipped(points: Array, polygon: Array, inset: float) -> Array:
    """Clip a convex polygon, segment or point (K, 2) to a polygon (Sutherland and Hodgman, 1974)."""
    for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if len(points) == 0:
            break
        inward = np.array([a[1] - b[1], b[0] - a[0]])
        inside = (points - a) @ (inward / np.linalg.norm(inward)) - inset
        points = _cut(points, inside)
    return points.reshape(-1, 2)


def _cut(points: Array, inside: Array) -> Array:
    """The part of a polygon, segment or point on the side where ``inside`` (K,) is not negative."""
    kept: list[tuple[float, float]] = []
    n = len(points)
    corners, sides = points.tolist(), inside.tolist()  # Python floats are much faster here than numpy's
    for i, ((x, y), side) in enumerate(zip(corners, sides, strict=True)):
        if side >= -_POINT_TOLERANCE:
            kept.append((x, y))
        j = (i + 1) % n
        if (
            n > 1
            and (side > _POINT_TOLERANCE) != (sides[j] > _POINT_TOLERANCE)
            and abs(side - sides[j]) > 2 * _POINT_TOLERANCE
        ):
            s = side / (side - sides[j])
            if 0.0 < s < 1.0 and not (n == 2 and i == 1):
                kept.append((x + s * (corners[j][0] - x), y + s * (corners[j][1] - y)))
    return np.array(kept).reshape(-1, 2)


def _crossing(a: Array, b: Array) -> Array:
    """Intersection of two points or segments (1 or 2, 2): a point, or their common stretch."""
    if len(a) == 1 or len(b) == 1:
        return a if len(a) == 1 else b
    along, other = a[1] - a[0], b[1] - b[0]
    sine = along[0] * other[1] - along[1] * other[0]
    if abs(sine) <= np.sin(np.radians(5.0)) * float(np.linalg.norm(along) * np.linalg.norm(other)):
        s = np.clip((b - a[0]) @ along / float(along @ along), 0.0, 1.0)
        return np.asarray(a[0] + s[:, None] * along)
    between = b[0] - a[0]
    s = float(np.clip((between[0] * other[1] - between[1] * other[0]) / sine, 0.0, 1.0))
    return np.asarray(a[0] + s * along)[None]
