"""Bodies of items with hollows: convex solids that fill the outer shape but for all hollows.

A box is cut along the sides of its hollows; a cylinder is a stack of discs and of rings of boxes. The boxes
of a ring reach from the chords of the hollow to those of the cylinder: into the hollow by its radius times
1 - cos(pi / 12) at most, and nowhere out of the cylinder. So a tool that misses the hollow collides.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.item import Item
from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.geometry import Array, pose, rotation_rpy

N_AROUND = 12  # boxes of a ring
THINNEST = 1e-6  # m, thinner cells are rounding


def solids_of(item: Item) -> tuple[Body, ...]:
    """Divide an item into convex solids.

    Args:
        item: The item.

    Returns:
        The solids in the item frame: its shape alone if it has no hollows.
    """
    if not item.hollows:
        return (Body("", item.shape, np.eye(4)),)
    return tuple(_rings(item) if item.shape.kind is ShapeKind.CYLINDER else _cells(item))


def _rings(item: Item) -> list[Body]:
    """Divide a cylinder at the bottoms of its hollows into discs and rings."""
    outer, length = item.shape.size
    heights = sorted({-length / 2, length / 2, *(hollow.height(item.shape) for hollow in item.hollows)})
    found = []
    for low, high in pairwise(heights):
        middle = np.array([0.0, 0.0, (low + high) / 2])
        inner = next((h.radius for h in item.hollows if h.contains(item.shape, middle)), None)
        if inner is None:
            found.append(Body("", Shape(ShapeKind.CYLINDER, (outer, high - low)), pose(middle)))
        else:
            found += _ring(inner, outer, middle, high - low)
    return found


def _ring(inner: float, outer: float, middle: Array, height: float) -> list[Body]:
    half = np.pi / N_AROUND
    near, far = inner * np.cos(half), outer * np.cos(half)
    box = Shape(ShapeKind.BOX, (float(far - near), float(2.0 * outer * np.sin(half)), height))
    turns = (np.asarray(rotation_rpy(0.0, 0.0, float(angle))) for angle in 2.0 * half * np.arange(N_AROUND))
    return [Body("", box, pose(middle + R @ ((near + far) / 2, 0.0, 0.0), R=R)) for R in turns]


def _cells(item: Item) -> list[Body]:
    """Divide a box along the sides and bottoms of its hollows, and join the cells that are left to boxes."""
    half = item.shape.extents / 2
    cuts = [np.array(_cuts(axis, float(half[axis]), item)) for axis in range(3)]
    middles = np.stack(np.meshgrid(*((cut[:-1] + cut[1:]) / 2 for cut in cuts), indexing="ij"), axis=-1)
    is_left = ~np.any([hollow.contains(item.shape, middles) for hollow in item.hollows], axis=0)
    found = []
    while is_left.any():
        start = np.argwhere(is_left)[0]
        end = start + 1
        for axis in range(3):
            while end[axis] < is_left.shape[axis]:
                longer = end.copy()
                longer[axis] += 1
                if not is_left[_cells_between(start, longer)].all():
                    break
                end = longer
        is_left[_cells_between(start, end)] = False
        found.append(_box(np.array([[cut[i], cut[j]] for cut, i, j in zip(cuts, start, end, strict=True)]).T))
    return found


def _cells_between(start: NDArray[np.intp], end: NDArray[np.intp]) -> tuple[slice, ...]:
    return tuple(slice(int(i), int(j)) for i, j in zip(start, end, strict=True))


def _cuts(axis: int, half: float, item: Item) -> list[float]:
    """Return sorted coordinates along an axis at which a box is cut, its ends included."""
    inside = (float(end) for hollow in item.hollows for end in hollow.bounds(item.shape)[:, axis])
    cuts = [-half]
    for cut in sorted((*inside, half)):
        if cut > cuts[-1] + THINNEST:
            cuts.append(cut)
    return cuts


def _box(ends: Array) -> Body:
    size = tuple(float(side) for side in np.ptp(ends, axis=0))
    return Body("", Shape(ShapeKind.BOX, size), pose(ends.mean(axis=0)))
