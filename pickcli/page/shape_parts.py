"""Converts shapes to data of a page."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.spatial import ConvexHull

from pickcli.cell.hollow_body import solids_of
from pickcli.cell.item import Item
from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.files.packed_array import packed
from pickcli.geometry import Array, transform_points
from pickcli.page.page_scene import PageBody, PageShape, posed, rounded

CORNER_RESOLUTION = 1e-4  # m, resolution of mesh corners
_N_SIDES = 48  # of the polyhedron that a cylinder is drawn as


def drawn_body(body: Body, colour: str = "") -> PageBody:
    """Convert a body.

    Args:
        body: The body.
        colour: As #rrggbb; "" for the colour of its owner.

    Returns:
        The body, in the same frame.
    """
    return PageBody(body.name, drawn_shape(body.shape, colour), posed(body.T_parent_shape))


def drawn_shape(shape: Shape, colour: str = "") -> PageShape:
    """Convert a shape.

    Args:
        shape: The shape.
        colour: As #rrggbb; "" for the colour of its owner.

    Returns:
        The shape; a hull as a mesh.
    """
    if shape.kind is ShapeKind.HULL:
        corners, triangles = _faces(shape)
        return mesh(corners, triangles, colour)
    return PageShape(str(shape.kind), rounded(shape.size), colour=colour)


def drawn_item(item: Item) -> PageShape:
    """Convert an item.

    Args:
        item: The item.

    Returns:
        The shape; with hollows a mesh of its body, without them.
    """
    if not item.hollows:
        return drawn_shape(item.shape)
    corners, triangles, n = list[Array](), list[Array](), 0
    for body in solids_of(item):
        points, faces = _faces(_as_hull(body.shape))
        corners.append(transform_points(body.T_parent_shape, points))
        triangles.append(faces + n)
        n += len(points)
    return mesh(np.concatenate(corners), np.concatenate(triangles))


def _as_hull(shape: Shape) -> Shape:
    """Return a box or cylinder as a polyhedron."""
    x, y, z = shape.extents / 2
    angles = 2.0 * np.pi * np.arange(_N_SIDES) / _N_SIDES
    around = np.column_stack([x * np.cos(angles), y * np.sin(angles)])
    if shape.kind is ShapeKind.BOX:
        around = np.array([(-x, -y), (x, -y), (x, y), (-x, y)])
    corners = [(float(a), float(b), float(c)) for c in (-z, z) for a, b in around]
    return Shape(ShapeKind.HULL, tuple(float(side) for side in shape.extents), tuple(corners))


def mesh(corners: Array, triangles: Array, colour: str = "", is_smooth: bool = False) -> PageShape:
    """Convert a mesh.

    Args:
        corners: (V, 3) m.
        triangles: (F, 3) indices of corners.
        colour: As #rrggbb; "" for the colour of its owner.
        is_smooth: Whether edges between triangles are shaded smoothly.

    Returns:
        The shape.
    """
    return PageShape(
        "mesh", (), packed(corners, CORNER_RESOLUTION), packed(triangles, 1.0), colour, is_smooth
    )


@lru_cache(maxsize=256)
def _faces(shape: Shape) -> tuple[Array, Array]:
    """Corners (V, 3) of a hull and its triangles (F, 3), with outward normals."""
    points = np.array(shape.vertices)
    hull = ConvexHull(points)
    numbers = np.full(len(points), -1)
    numbers[hull.vertices] = np.arange(len(hull.vertices))
    a, b, c = (points[hull.simplices[:, i]] for i in range(3))
    is_inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    triangles = np.where(is_inward[:, None], hull.simplices[:, ::-1], hull.simplices)
    return points[hull.vertices], numbers[triangles]
