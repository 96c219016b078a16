"""Hollows of items: parts that are missing from their outer shape, each open through one flat face.

The outer shape stays what other items, places and links see: it is the room that an item takes. Only a tool
that takes the item by the bottom of one of its hollows may enter that hollow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.shapes import Shape
from pickcli.geometry import Array


@dataclass(frozen=True)
class Hollow:
    """A convex piece cut out of a box, or out of an end of a cylinder.

    Attributes:
        name: Unique among the hollows of its item.
        face: Flat face of the outer shape that it opens through, e.g. "+z".
        depth: m, from that face to its flat bottom.
        radius: m, of a round hollow about the axis of a cylinder; None for a rectangular one.
        sides: m, [least, greatest] of a rectangular hollow along both axes of the face, in the order x, y, z;
            () for a round one. A side on the edge of the face is open.
    """

    name: str
    face: str
    depth: float
    radius: float | None = None
    sides: tuple[tuple[float, float], ...] = ()

    @property
    def bottom(self) -> str:
        """Name of the face at its bottom, e.g. "+z/bowl"."""
        return f"{self.face}/{self.name}"

    @property
    def axis(self) -> int:
        """Index of the axis of the item frame along which it leads into the item."""
        return "xyz".index(self.face[1])

    @property
    def across(self) -> tuple[int, int]:
        """Indices of the axes along its bottom."""
        first, second = (k for k in range(3) if k != self.axis)
        return first, second

    def opens(self, shape: Shape) -> tuple[str, ...]:
        """Return the outer faces that it opens through: its own, and those at whose edge a side is open.

        Args:
            shape: Outer shape of the item.

        Returns:
            Names of the faces.
        """
        low, high = self.bounds(shape)
        half, found = shape.extents / 2, [self.face]
        for k in self.across if self.radius is None else ():
            found += [f"-{'xyz'[k]}"] if low[k] <= -half[k] else []
            found += [f"+{'xyz'[k]}"] if high[k] >= half[k] else []
        return tuple(found)

    @property
    def width(self) -> float:
        """Narrowest width of the hollow, m."""
        if self.radius is not None:
            return 2.0 * self.radius
        return min(greatest - least for least, greatest in self.sides)

    def height(self, shape: Shape) -> float:
        """Return the coordinate of its bottom.

        Args:
            shape: Outer shape of the item.

        Returns:
            m along its axis in the item frame.
        """
        side = -1.0 if self.face[0] == "-" else 1.0
        return side * (float(shape.extents[self.axis]) / 2 - self.depth)

    def bounds(self, shape: Shape) -> Array:
        """Return the box around it.

        Args:
            shape: Outer shape of the item.

        Returns:
            (2, 3) m, least and greatest corner in the item frame.
        """
        rims = [0.0, 0.0, 0.0]
        rims[self.axis] = float(shape.extents[self.axis]) / 2 * (-1.0 if self.face[0] == "-" else 1.0)
        ends = np.zeros((2, 3))
        ends[:, self.axis] = sorted((self.height(shape), rims[self.axis]))
        radius = self.radius or 0.0
        for axis, side in zip(self.across, self.sides or ((-radius, radius),) * 2, strict=True):
            ends[:, axis] = side
        return ends

    def contains(self, shape: Shape, points: Array) -> NDArray[np.bool_]:
        """Find the points in the hollow.

        Args:
            shape: Outer shape of the item.
            points: (..., 3) m in the item frame.

        Returns:
            (...) True inside and on its surface.
        """
        low, high = self.bounds(shape)
        inside = ((low <= points) & (points <= high)).all(axis=-1)
        if self.radius is not None:
            inside &= (points[..., self.across] ** 2).sum(axis=-1) <= self.radius**2
        return np.asarray(inside)
