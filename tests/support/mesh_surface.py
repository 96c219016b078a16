"""Points on the surfaces of meshes, and how far they lie outside of shapes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pickcli.cell.shapes import Body, ShapeKind
from pickcli.geometry import Array, inverse, transform_points
from pickcli.meshes.mesh_file import parse_triangles, read_mesh_bytes


def surface_points(path: Path, n: int, rng: np.random.Generator) -> Array:
    """Draw points evenly from a mesh's surface, and take its corners.

    Args:
        path: STL, OBJ or COLLADA.
        n: Number of points drawn.
        rng: Source of random numbers.

    Returns:
        (N, 3) m, in the mesh's frame.
    """
    triangles = np.asarray(parse_triangles(path, read_mesh_bytes(path), (1.0, 1.0, 1.0))).reshape(-1, 3, 3)
    a, b, c = triangles.transpose(1, 0, 2)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    k = rng.choice(len(triangles), n, p=area / area.sum())
    u, v = rng.random((2, n, 1))
    u, v = np.where(u + v > 1.0, 1.0 - u, u), np.where(u + v > 1.0, 1.0 - v, v)
    return np.concatenate([triangles.reshape(-1, 3), a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k])])


def outside(points: Array, bodies: Sequence[Body]) -> Array:
    """How far points lie outside of the union of boxes, cylinders and spheres.

    Args:
        points: (N, 3) m, in the bodies' parent frame.
        bodies: The bodies.

    Returns:
        (N,) m, 0 inside.
    """
    apart = [_outside(transform_points(inverse(each.T_parent_shape), points), each) for each in bodies]
    return np.asarray(np.min(apart, axis=0))


def _outside(points: Array, body: Body) -> Array:
    """(N,) m, of points in the shape's own frame."""
    shape = body.shape
    if shape.kind is ShapeKind.SPHERE:
        return np.asarray(np.maximum(np.linalg.norm(points, axis=1) - shape.size[0], 0.0))
    if shape.kind is ShapeKind.BOX:
        return np.asarray(np.linalg.norm(np.maximum(np.abs(points) - shape.extents / 2, 0.0), axis=1))
    radius, length = shape.size
    aside = np.hypot(points[:, 0], points[:, 1]) - radius
    beyond = np.maximum(np.abs(points[:, 2]) - length / 2, 0.0)
    return np.asarray(np.hypot(np.maximum(aside, 0.0), beyond))
