"""Samples a placement of one item in each of many alternative packings of the same bin.

Items are nearly parallel to the walls, so each is represented by its bounding box in the bin frame: if boxes
do not overlap, neither do the items.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.geometry import Array
from pickcli.random_scenes.box_arrays import Bools, BoxArrays, gap
from pickcli.random_scenes.stable_poses import stable_poses

Indices: TypeAlias = NDArray[np.intp]

FRONT = 0.020  # m kept free behind the mouth: lips are up to 20 mm deep
GAPS = (0.003, 0.028)  # m between neighbours and to walls
SNUG = 0.004  # m above the smallest gap while cramming
CEILING_GAP = 0.010  # m
MOUTH_GAP = 0.026  # m between an item's height and that of the mouth it was inserted through
RAISING_GAP = 0.002  # m between the diagonal of a tilted item and the height of the bin
DROP = 0.001  # m above the supporting surface
TOP_HEIGHT_TOLERANCE = 0.005  # m, difference in height of tops that support together
LEAST_SUPPORT = 0.6  # least supported share of a base, on all sides of its centre
MAX_LEAN_DISTANCE = 0.025  # m, largest distance to the wall that keeps a thin item on its edge
SPREAD = np.radians(1.5)  # standard deviation of the angle to the walls
ANYWHERE = 0.3  # share of placements that are not next to a wall or neighbour

RAISED = 10.0  # cost of lying on other items
HEIGHT = 40.0  # additional cost per metre above the floor
TOSSED = 40.0  # additional cost without enough support
UPRIGHT = 0.2  # cost of a pose higher than necessary
ON_EDGE = 3.0  # cost of standing on an edge


@dataclass(frozen=True, eq=False)
class Placements:
    """Placements of items in the bin frame, in arrays of any shape (...).

    Attributes:
        R: (..., 3, 3) orientations.
        centre: (..., 3) m, centres.
        boxes: (..., 3) boxes around them, aligned with the bin.
        pitch: (...) rad, slope of the supporting surface.
        is_level: (...) whether others can lie on them.
        own: (...) cost of the pose itself, infinite if impossible.
        leans_on: (...) index of the item that it leans on, -1 if it leans on none.
    """

    R: Array
    centre: Array
    boxes: BoxArrays
    pitch: Array
    is_level: Bools
    own: Array
    leans_on: Indices


def random_placements(
    cell_bin: Place, item: Item, there: Placements, is_snug: Bools, may_raise: bool, rng: np.random.Generator
) -> Placements:
    """Draw a placement for one item in each of N packings.

    Args:
        cell_bin: The bin.
        item: The item.
        there: (N, M) placements of the M items in each packing.
        is_snug: (N,) whether to save space, by square poses with small gaps.
        may_raise: Whether the item may be higher than the mouth, inserted lying and tilted up inside.
        rng: Source of random numbers.

    Returns:
        (N,) placements.
    """
    n = len(there.own)
    kinds, weights = zip(*stable_poses(item), strict=True)
    pick = rng.choice(len(kinds), n, p=weights)
    height = np.array([kind.height for kind in kinds])[pick]
    can_roll = np.array([kind.can_roll for kind in kinds])[pick]
    on_edge = np.array([kind.is_on_edge for kind in kinds])[pick]
    quarter = rng.integers(4, size=n)
    askew = np.clip(rng.normal(0.0, SPREAD, n), -2 * SPREAD, 2 * SPREAD) * ~(can_roll | is_snug)
    R = about_z(quarter * np.pi / 2 + askew) @ np.array([kind.R_up_item for kind in kinds])[pick]
    half = item.shape.reach(R)[:, :2]
    middle = _middles(cell_bin, half, there.boxes, is_snug, rng)
    base, pitch, own = _rest(cell_bin, middle, half, there)
    R = about_y(pitch) @ R
    up = np.stack([np.sin(pitch), np.zeros(n), np.cos(pitch)], axis=1)
    centre = np.column_stack([middle, base + DROP]) + height[:, None] / 2 * up
    reach = item.shape.reach(R)
    boxes = BoxArrays(centre - reach, centre + reach)
    is_across = quarter % 2 == 1
    possible = _is_inside(cell_bin, boxes) & (
        _enters_upright(cell_bin, height) | (may_raise & _can_be_raised(cell_bin, item, height))
    )
    possible &= (own > 0.0) | (gap(boxes.column, there.boxes) >= GAPS[0]).all(axis=1)
    # On the slope, items must not roll down or stand on an edge across it.
    is_flat = middle[:, 0] - half[:, 0] >= cell_bin.room.floor_flat_from
    possible &= ~((can_roll | on_edge) & is_across) | is_flat
    possible &= ~on_edge | ((own == 0.0) & _is_leaning(cell_bin, boxes, is_across))
    own = own + UPRIGHT * (height > height.min()) + ON_EDGE * on_edge
    is_level = np.array([kind.is_level for kind in kinds])[pick]
    own = np.where(possible, own, np.inf)
    return Placements(R, centre, boxes, pitch, is_level, own, np.full(n, -1, dtype=np.intp))


def from_corner(cell_bin: Place, boxes: BoxArrays) -> Array:
    """Compute the distance of boxes from the back of a bin plus that from its nearer side, as wasted room.

    Args:
        cell_bin: The bin.
        boxes: Boxes (..., 3), bin frame.

    Returns:
        (...) m.
    """
    lower, upper = _room_of_centres(cell_bin)
    to_side = np.minimum(boxes.low[..., 1] - lower[1], upper[1] - boxes.high[..., 1])
    return np.asarray(upper[0] - boxes.high[..., 0] + to_side)


def _room_of_centres(cell_bin: Place) -> tuple[Array, Array]:
    """Lower and upper (x, y) of the usable part of a bin, bin frame, m."""
    low, high = cell_bin.room.y_range
    return np.array([FRONT, low]), np.array([cell_bin.room.depth, high])


def _middles(
    cell_bin: Place, half: Array, there: BoxArrays, is_snug: Bools, rng: np.random.Generator
) -> Array:
    """Centres (N, 2) of bases: anywhere, or at a gap from a wall or another item."""
    n, m = there.low.shape[:2]
    lower, upper = _room_of_centres(cell_bin)
    anywhere = lower + half + rng.random((n, 2)) * (upper - lower - 2 * half)
    # Edges of walls and neighbours: near side plus the gap, far side minus it.
    edges = np.concatenate(
        [np.tile([lower, upper], (n, 1, 1)), there.high[..., :2], there.low[..., :2]], axis=1
    )
    sign = np.concatenate([[1.0, -1.0], np.ones(m), -np.ones(m)])
    pick = rng.integers(len(sign), size=(n, 2))
    edge = np.take_along_axis(edges, pick[:, None, :], axis=1)[:, 0]
    gaps = GAPS[0] + rng.random((n, 2)) * np.where(is_snug, SNUG, GAPS[1] - GAPS[0])[:, None]
    beside = edge + sign[pick] * (half + gaps)
    is_free = (rng.random((n, 2)) < ANYWHERE * ~is_snug[:, None]) | (beside < lower) | (beside > upper)
    return np.where(is_free, anywhere, beside)


def _rest(cell_bin: Place, middle: Array, half: Array, there: Placements) -> tuple[Array, Array, Array]:
    """Height (N,) of the supporting surface, its pitch, and the cost of lying on it: 0 on the floor."""
    low, high = (middle - half)[:, None] - GAPS[0], (middle + half)[:, None] + GAPS[0]
    below = np.all((low < there.boxes.high[..., :2]) & (there.boxes.low[..., :2] < high), axis=2)
    base, pitch = cell_bin.room.rest(middle[:, 0], half[:, 0])
    raised = np.flatnonzero(below.any(axis=1))
    own = np.zeros(len(middle))
    if len(raised):
        tops = np.where(below, there.boxes.high[..., 2], -np.inf)[raised]
        highest, top = tops.argmax(axis=1), tops.max(axis=1)
        carries = below[raised] & there.is_level[raised] & (tops >= top[:, None] - TOP_HEIGHT_TOLERANCE)
        carried = _carried(middle[raised], half[raised], there.boxes[raised], carries)
        own[raised] = RAISED + HEIGHT * (top - cell_bin.room.floor_back) + TOSSED * (carried < LEAST_SUPPORT)
        base[raised], pitch[raised] = top, there.pitch[raised, highest]
    return base, pitch, own


def _carried(middle: Array, half: Array, there: BoxArrays, carries: Bools) -> Array:
    """Supported share (N,) of a base; 0 if its centre is outside the supporting surfaces."""
    low = np.maximum((middle - half)[:, None], there.low[..., :2])
    high = np.minimum((middle + half)[:, None], there.high[..., :2])
    area = np.where(carries, np.prod(np.maximum(high - low, 0.0), axis=2), 0.0).sum(axis=1)
    first = np.where(carries[..., None], low, np.inf).min(axis=1)
    last = np.where(carries[..., None], high, -np.inf).max(axis=1)
    is_balanced = ((first < middle) & (middle < last)).all(axis=1)
    return np.asarray(is_balanced * area / np.prod(2 * half, axis=1))


def _is_inside(cell_bin: Place, boxes: BoxArrays) -> Bools:
    lower, upper = _room_of_centres(cell_bin)
    is_below = boxes.high[:, 2] <= cell_bin.room.ceiling_back - CEILING_GAP
    is_short = (boxes.low[:, 0] >= lower[0]) & (boxes.high[:, 0] <= upper[0] - GAPS[0])
    is_narrow = (boxes.low[:, 1] >= lower[1] + GAPS[0]) & (boxes.high[:, 1] <= upper[1] - GAPS[0])
    return np.asarray(is_below & is_short & is_narrow)


def _enters_upright(cell_bin: Place, height: Array) -> Bools:
    """Whether items with heights (N,) in m pass the mouth upright."""
    return np.asarray(height <= cell_bin.access.height - MOUTH_GAP)


def _can_be_raised(cell_bin: Place, item: Item, height: Array) -> Bools:
    """Whether an item inserted lying can be tilted up to a height (N,), about its thinnest side."""
    thin, middle, _ = np.sort(item.shape.extents)
    enters_lying = _enters_upright(cell_bin, thin) & (middle <= cell_bin.access.width)
    clear = cell_bin.room.ceiling_back - cell_bin.room.floor_back - RAISING_GAP
    return np.asarray(enters_lying & (np.hypot(height, thin) <= clear))


def _is_leaning(cell_bin: Place, boxes: BoxArrays, is_across: Bools) -> Bools:
    """Whether there is a wall next to the thin side, or behind it if the item is across."""
    lower, upper = _room_of_centres(cell_bin)
    to_side = np.minimum(boxes.low[:, 1] - lower[1], upper[1] - boxes.high[:, 1])
    return np.asarray(np.where(is_across, upper[0] - boxes.high[:, 0], to_side) <= MAX_LEAN_DISTANCE)


def about_z(angle: Array) -> Array:
    """Compute rotations about the vertical.

    Args:
        angle: (N,) rad.

    Returns:
        (N, 3, 3).
    """
    R = np.zeros((len(angle), 3, 3))
    R[:, 0, 0] = R[:, 1, 1] = np.cos(angle)
    R[:, 1, 0], R[:, 0, 1], R[:, 2, 2] = np.sin(angle), -np.sin(angle), 1.0
    return R


def about_y(angle: Array) -> Array:
    """Compute pitch rotations, positive downwards towards the back.

    Args:
        angle: (N,) rad.

    Returns:
        (N, 3, 3).
    """
    R = np.zeros((len(angle), 3, 3))
    R[:, 0, 0] = R[:, 2, 2] = np.cos(angle)
    R[:, 0, 2], R[:, 2, 0], R[:, 1, 1] = np.sin(angle), -np.sin(angle), 1.0
    return R
