"""Convex solids that cover an item but for one of its hollows: what is under it, and the walls around it.

For the tool that takes an item by the bottom of a hollow they replace the outer shape. Every point of that
shape outside of the hollow is in one of them; other hollows of the item are filled. The walls of a round
hollow are boxes whose inner sides are chords of it, so these reach into it by its radius times
1 - cos(pi / 16) at most, and out of the cylinder by 2 per cent of its radius.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.hollow import Hollow
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, pose, rotation_rpy

N_WALLS = 16  # boxes around a round hollow
# m, longest piece of a wall: an error of the item's angle moves near ones less than far ones
LONGEST = 0.025


@dataclass(frozen=True, eq=False)
class CoverPiece:
    """One of the solids.

    Attributes:
        shape: The solid.
        T_item_shape: (4, 4) its pose in the item frame.
        is_wall: Whether it is beside the hollow, where nothing of the tool may touch it.
    """

    shape: Shape
    T_item_shape: Array
    is_wall: bool

    @property
    def farthest(self) -> float:
        """Greatest distance of a point of it from the middle of the item, m."""
        if self.shape.kind is ShapeKind.CYLINDER:
            radius, length = self.shape.size
            return float(np.hypot(radius, abs(self.T_item_shape[2, 3]) + length / 2))
        R, p = self.T_item_shape[:3, :3], self.T_item_shape[:3, 3]
        return float(np.linalg.norm(np.abs(R.T @ p) + self.shape.extents / 2))


def cover_around(shape: Shape, hollow: Hollow) -> tuple[CoverPiece, ...]:
    """Cover a shape but for one hollow.

    Args:
        shape: Outer shape of the item.
        hollow: One of its hollows.

    Returns:
        The solid under the hollow, then the walls beside it, which end at its rim.
    """
    low, high = -shape.extents / 2, shape.extents / 2
    bounds, axis = hollow.bounds(shape), hollow.axis
    under = np.stack([low, high])
    # The end of the solid under the hollow is its bottom.
    under[1 if hollow.face[0] == "+" else 0, axis] = hollow.height(shape)
    if hollow.radius is None:
        return (_box(under, is_wall=False), *_walls(np.stack([low, high]), bounds, hollow.across))
    thick, deep = float(np.ptp(under[:, 2])), float(np.ptp(bounds[:, 2]))
    slab = Shape(ShapeKind.CYLINDER, (shape.size[0], thick))
    bottom = CoverPiece(slab, pose((0.0, 0.0, float(under[:, 2].mean()))), is_wall=False)
    return (bottom, *_ring(hollow.radius, shape.size[0], float(bounds[:, 2].mean()), deep))


def _walls(outer: Array, bounds: Array, across: tuple[int, int]) -> list[CoverPiece]:
    """Return the boxes between a hollow (2, 3) and the sides of a box (2, 3), none where they meet."""
    first, second = across
    found = []
    for axis, along in ((first, bounds.copy()), (second, bounds.copy())):
        if axis == first:  # these two walls are as long as the box
            along[:, second] = outer[:, second]
        for ends in ((outer[0, axis], bounds[0, axis]), (bounds[1, axis], outer[1, axis])):
            wall = along.copy()
            wall[:, axis] = ends
            if ends[1] > ends[0]:
                found += [_box(piece, is_wall=True) for piece in _divided(wall, across)]
    return found


def _divided(wall: Array, across: tuple[int, int]) -> list[Array]:
    """Divide a box (2, 3) along two axes into pieces of equal length, none longer than the longest."""
    pieces = [wall]
    for axis in across:
        n = int(np.ceil(np.ptp(wall[:, axis]) / LONGEST))
        ends = np.linspace(float(wall[0, axis]), float(wall[1, axis]), n + 1)
        pieces = [_with(piece, axis, ends[i : i + 2]) for piece in pieces for i in range(n)]
    return pieces


def _with(ends: Array, axis: int, along: Array) -> Array:
    changed = ends.copy()
    changed[:, axis] = along
    return changed


def _box(ends: Array, is_wall: bool) -> CoverPiece:
    size = tuple(float(side) for side in np.ptp(ends, axis=0))
    return CoverPiece(Shape(ShapeKind.BOX, size), pose(ends.mean(axis=0)), is_wall)


def _ring(inner: float, outer: float, middle: float, height: float) -> list[CoverPiece]:
    """Return boxes around the part of a ring between two radii, all in m; middle: of their heights."""
    half = np.pi / N_WALLS
    least = inner * float(np.cos(half))
    box = Shape(ShapeKind.BOX, (outer - least, 2.0 * outer * float(np.sin(half)), height))
    found = []
    for angle in 2.0 * half * np.arange(N_WALLS):
        R = np.asarray(rotation_rpy(0.0, 0.0, float(angle)))
        at = R @ ((least + outer) / 2, 0.0, 0.0) + (0.0, 0.0, middle)
        found.append(CoverPiece(box, pose(at, R=R), is_wall=True))
    return found
