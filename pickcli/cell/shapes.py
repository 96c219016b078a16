"""Solid shapes of links, obstacles and items."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pickcli.errors import InputError
from pickcli.geometry import Array, pose

Corner = tuple[float, float, float]  # m


class ShapeKind(StrEnum):
    """Kinds of solids. Hulls occur only in robots."""

    BOX = "box"
    CYLINDER = "cylinder"
    SPHERE = "sphere"
    HULL = "hull"


@dataclass(frozen=True)
class Shape:
    """A solid centred on its own frame.

    Attributes:
        kind: Kind of solid.
        size: m: box (x, y, z) full extents; cylinder (radius, length along z); sphere (radius,); hull (x, y,
            z) full extents of its bounding box, whose centre is the origin of its frame.
        vertices: m, corners of a hull's convex polyhedron in its own frame. Empty for other kinds.
    """

    kind: ShapeKind
    size: tuple[float, ...]
    vertices: tuple[tuple[float, float, float], ...] = ()

    @property
    def extents(self) -> Array:
        """Full extents (3,) of the axis-aligned box around the shape in its own frame, m."""
        if self.kind in (ShapeKind.BOX, ShapeKind.HULL):
            return np.array(self.size)
        if self.kind is ShapeKind.CYLINDER:
            radius, length = self.size
            return np.array([2 * radius, 2 * radius, length])
        return np.full(3, 2 * self.size[0])

    @cached_property
    def bounding_radius(self) -> float:
        """Radius of the ball around the axis-aligned box around the shape, m."""
        return float((self.extents**2).sum() ** 0.5) / 2

    def reach(self, R: Array) -> Array:
        """Compute the half extents along the axes of a rotated frame.

        Args:
            R: (..., 3, 3) orientation of the shape in that frame.

        Returns:
            (..., 3) m.
        """
        if self.kind is ShapeKind.SPHERE:
            return np.full(R.shape[:-1], self.size[0])
        if self.kind is ShapeKind.BOX:
            return np.asarray(np.abs(R) @ (np.array(self.size) / 2))
        if self.kind is ShapeKind.HULL:
            return np.asarray(np.abs(R @ np.array(self.vertices).T).max(axis=-1))
        radius, length = self.size
        along = np.abs(R[..., :, 2])
        return np.asarray(length / 2 * along + radius * np.sqrt(np.maximum(0.0, 1.0 - along**2)))

    @property
    def face_names(self) -> tuple[str, ...]:
        """Names of the faces: outward directions of flat ones, else "mantle" and "sphere"."""
        self._refuse_hull()
        if self.kind is ShapeKind.BOX:
            return ("+x", "-x", "+y", "-y", "+z", "-z")
        return ("+z", "-z", "mantle") if self.kind is ShapeKind.CYLINDER else ("sphere",)

    @property
    def inertia_per_mass(self) -> Array:
        """Inertia (3, 3) in m^2, per kg at uniform density, about the centre in the shape's own frame."""
        self._refuse_hull()
        if self.kind is ShapeKind.BOX:
            squares = np.square(self.size)
            return np.diag((squares.sum() - squares) / 12.0)
        if self.kind is ShapeKind.CYLINDER:
            radius, length = self.size
            across = (3.0 * radius**2 + length**2) / 12.0
            return np.diag([across, across, radius**2 / 2.0])
        return np.asarray(0.4 * self.size[0] ** 2 * np.eye(3))

    @property
    def volume(self) -> float:
        """Volume in m^3."""
        self._refuse_hull()
        if self.kind is ShapeKind.BOX:
            return float(np.prod(self.size))
        if self.kind is ShapeKind.CYLINDER:
            return float(np.pi * self.size[0] ** 2 * self.size[1])
        return float(4.0 / 3.0 * np.pi * self.size[0] ** 3)

    def inflated(self, by: float) -> Shape:
        """Grow the shape on every side.

        The result contains every point within ``by`` of the shape; edges stay sharp where the exact offset is
        rounded.

        Args:
            by: m.

        Returns:
            The larger shape.
        """
        self._refuse_hull()
        if self.kind is ShapeKind.BOX:
            return Shape(self.kind, tuple(s + 2 * by for s in self.size))
        if self.kind is ShapeKind.CYLINDER:
            return Shape(self.kind, (self.size[0] + by, self.size[1] + 2 * by))
        return Shape(self.kind, (self.size[0] + by,))

    def contains(self, points: Array) -> NDArray[np.bool_]:
        """Find the points inside of the shape.

        Args:
            points: (..., 3) m in its own frame; NaN is nowhere.

        Returns:
            (...) True inside and on the surface.
        """
        self._refuse_hull()
        if self.kind is ShapeKind.SPHERE:
            return np.asarray((points**2).sum(axis=-1) <= self.size[0] ** 2)
        if self.kind is ShapeKind.CYLINDER:
            is_around = (points[..., :2] ** 2).sum(axis=-1) <= self.size[0] ** 2
            return np.asarray(is_around & (np.abs(points[..., 2]) <= self.size[1] / 2))
        return np.asarray((np.abs(points) <= np.array(self.size) / 2).all(axis=-1))

    def _refuse_hull(self) -> None:
        """Raise ValueError for a hull, which items cannot be."""
        if self.kind is ShapeKind.HULL:
            raise ValueError("a hull is part of a robot, not an item")


@dataclass(frozen=True, eq=False)
class MeshPiece:
    """The mesh of which a hull is a convex piece.

    Attributes:
        path: Its file.
        scale: (3,) factors on x, y and z of the file.
        T_shape_mesh: (4, 4) pose of the mesh in the frame of the hull.
    """

    path: Path
    scale: tuple[float, ...]
    T_shape_mesh: Array


@dataclass(frozen=True, eq=False)
class Body:
    """A named shape in a parent frame: world, pod, link or item, as its owner states.

    Attributes:
        name: Unique in its owner.
        shape: The shape.
        T_parent_shape: (4, 4) pose of the shape.
        piece_of: The mesh that a hull is a piece of; None for other shapes.
    """

    name: str
    shape: Shape
    T_parent_shape: Array
    piece_of: MeshPiece | None = None


def hull(name: str, points: Array) -> Body:
    """Build the convex hull of points.

    Args:
        name: Name of the body.
        points: (V, 3) m in the parent frame, the corners of the hull.

    Returns:
        The body; its frame is centred in the points' bounding box and parallel to the parent's.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high) / 2
    corners = tuple((float(x), float(y), float(z)) for x, y, z in points - middle)
    size = tuple(float(v) for v in high - low)
    return Body(name, Shape(ShapeKind.HULL, size, corners), pose(middle))


def box(name: str, lower: Corner, upper: Corner) -> Body:
    """Build an axis-aligned box between two corners.

    Args:
        name: Name of the body.
        lower: Lower corner (x, y, z) in the parent frame, m.
        upper: Upper corner.

    Returns:
        The body.

    Raises:
        InputError: A corner is not three numbers.
    """
    try:
        lo, hi = (np.array(corner, dtype=float).reshape(3) for corner in (lower, upper))
    except (TypeError, ValueError):
        fault = f"expected two corners (x, y, z) in m, got {lower} and {upper}"
        raise InputError(f"box {name!r}: {fault}") from None
    T = np.eye(4)
    T[:3, 3] = (lo + hi) / 2
    return Body(name, Shape(ShapeKind.BOX, tuple(float(v) for v in hi - lo)), T)


def ring(
    name: str, low: Corner, high: Corner, outer_low: tuple[float, float], outer_high: tuple[float, float]
) -> list[Body]:
    """Build four upright bars around a rectangle, such as the walls of a box.

    Args:
        name: Prefix of the bars' names, followed by their sides.
        low: Lower corner (x, y, z) of the enclosed box, in the parent frame, m.
        high: Upper corner.
        outer_low: Lesser (x, y) of the bars' outer edges.
        outer_high: Greater (x, y) of the bars' outer edges.

    Returns:
        The bars: left (at greater y), right, near (at smaller x) and far.
    """
    (x0, y0, z0), (x1, y1, z1) = low, high
    (a0, b0), (a1, b1) = outer_low, outer_high
    return [
        box(f"{name}_left", (a0, y1, z0), (a1, b1, z1)),
        box(f"{name}_right", (a0, b0, z0), (a1, y0, z1)),
        box(f"{name}_near", (a0, y0, z0), (x0, y1, z1)),
        box(f"{name}_far", (x1, y0, z0), (a1, y1, z1)),
    ]
