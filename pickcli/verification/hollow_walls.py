"""The body of an item around the hollow that it is taken by: what lies under the cup, and what beside it.

Derived here once more, from the figures of the item file: the proofs of the planner rest on other solids. A
box is divided into slabs that overlap at its edges; a ring into staves, trapezoids between the chords of the
hollow and the tangents of the cylinder. Together they contain every point of the outer shape that is not in
the hollow.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import numpy as np

from pickcli.cell.hollow import Hollow
from pickcli.cell.item import Item
from pickcli.cell.shapes import Body, Shape, ShapeKind, hull
from pickcli.geometry import Array, pose

N_STAVES = 20
SLAB = 0.025  # m, longest side of a slab along the face: near the item's middle, errors of its angle are less


@dataclass(frozen=True, eq=False)
class OpenedItem:
    """An item but for one hollow.

    Attributes:
        under: What lies under the hollow, on which the cup is pressed.
        walls: What lies beside it, which nothing may touch.
    """

    under: Body
    walls: tuple[Body, ...]

    @property
    def all(self) -> tuple[Body, ...]:
        """All of its solids, in the item frame."""
        return (self.under, *self.walls)


def farthest_point(body: Body) -> float:
    """Bound the distance of the points of a solid from the middle of its item.

    Args:
        body: The solid, in the item frame.

    Returns:
        m.
    """
    T, half = body.T_parent_shape, body.shape.extents / 2
    corners = np.array(list(product((-1.0, 1.0), repeat=3))) * half
    return float(np.linalg.norm(corners @ T[:3, :3].T + T[:3, 3], axis=1).max())


@lru_cache(maxsize=64)
def opened(item: Item, face: str) -> OpenedItem | None:
    """Open an item where a grasp says that the cup is put on.

    Args:
        item: The item.
        face: The face that the grasp states.

    Returns:
        The solids in the item frame; None if the face is not the bottom of a hollow.
    """
    _, _, name = face.partition("/")
    hollow = next((each for each in item.hollows if each.name == name and each.face == face[:2]), None)
    if hollow is None:
        return None
    half = item.shape.extents / 2
    k, is_upper = "xyz".index(face[1]), face[0] == "+"
    low, high = -half.copy(), half.copy()
    if is_upper:
        high[k] = half[k] - hollow.depth
    else:
        low[k] = hollow.depth - half[k]
    beside = (half[k] - hollow.depth, half[k]) if is_upper else (-half[k], hollow.depth - half[k])
    if item.shape.kind is ShapeKind.CYLINDER:
        return OpenedItem(_disc(item.shape.size[0], (low[2], high[2])), tuple(_staves(item, hollow, beside)))
    return OpenedItem(_slab(low, high), tuple(_slabs(half, hollow, k, beside)))


def _disc(radius: float, ends: tuple[float, float]) -> Body:
    shape = Shape(ShapeKind.CYLINDER, (radius, ends[1] - ends[0]))
    return Body("", shape, pose((0.0, 0.0, (ends[0] + ends[1]) / 2)))


def _slab(low: Array, high: Array) -> Body:
    size = (float(high[0] - low[0]), float(high[1] - low[1]), float(high[2] - low[2]))
    return Body("", Shape(ShapeKind.BOX, size), pose((low + high) / 2))


def _slabs(half: Array, hollow: Hollow, k: int, beside: tuple[float, float]) -> Iterator[Body]:
    """Yield for each side of a rectangular hollow all of the box beyond it; none where it is open."""
    others = [axis for axis in range(3) if axis != k]
    for axis, (least, greatest) in zip(others, hollow.sides, strict=True):
        for start, end in ((-half[axis], least), (greatest, half[axis])):
            if end > start:
                low, high = -half.copy(), half.copy()
                low[k], high[k] = beside
                low[axis], high[axis] = start, end
                yield from _short_slabs(low, high, others)


def _short_slabs(low: Array, high: Array, along: list[int]) -> Iterator[Body]:
    """Divide a slab between two corners along two axes."""
    n = [max(1, int(np.ceil((high[axis] - low[axis]) / SLAB))) for axis in along]
    for cell in product(*(range(each) for each in n)):
        start, end = low.copy(), high.copy()
        for axis, i, each in zip(along, cell, n, strict=True):
            start[axis] = low[axis] + (high[axis] - low[axis]) * i / each
            end[axis] = low[axis] + (high[axis] - low[axis]) * (i + 1) / each
        yield _slab(start, end)


def _staves(item: Item, hollow: Hollow, beside: tuple[float, float]) -> Iterator[Body]:
    """Yield the staves around a round hollow, each over an N-th of a turn."""
    assert hollow.radius is not None
    share = np.pi / N_STAVES
    inner = hollow.radius
    outer = item.shape.size[0] / np.cos(share)  # the corners of tangents
    for j in range(N_STAVES):
        angles = (2 * j - 1) * share, (2 * j + 1) * share
        corners = [
            (radius * np.cos(angle), radius * np.sin(angle), z)
            for radius, angle, z in product((inner, outer), angles, beside)
        ]
        yield hull("", np.array(corners))
