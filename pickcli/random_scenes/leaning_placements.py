"""Samples placements of items that lean in a bin, on a wall or on a neighbour, in many packings at once.

A box leans in one of three ways. It stands on an edge with its top against a wall or against the side of a
neighbour, farther over than it would fall back; or it lies with one end on the floor and the other over the
upper edge of a neighbour, propped up. Angles are against the floor, up to 20 degrees.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.item import Item
from pickcli.cell.place import Place, Room
from pickcli.cell.shapes import ShapeKind
from pickcli.geometry import Array
from pickcli.random_scenes.box_arrays import Bools, BoxArrays, gap
from pickcli.random_scenes.placement_sampling import (
    CEILING_GAP,
    DROP,
    FRONT,
    GAPS,
    MOUTH_GAP,
    Placements,
    about_y,
    about_z,
)
from pickcli.random_scenes.stable_poses import LEAST_EDGE, upwards

LEAST_ANGLE, MOST_ANGLE = np.radians(3.0), np.radians(20.0)  # of an item that leans
DRAWN_ANGLES = np.radians([4.0, 18.0])  # an item turns a little farther until it touches
FALLS_BACK = np.radians(2.0)  # beyond the angle at which its middle is over its edge, from which it leans
TOUCH_GAP = 0.001  # m to what it leans on, before it comes to rest
LEAST_BACKING = 0.75  # of its height, up to which a neighbour must reach that it leans on
OVER_EDGE = (0.6, 0.92)  # shares of its length between the end on the floor and the edge that props it up
MOST_THICKNESS = 0.3  # of its length, of an item that is propped up
LEAST_MASS = 0.5  # of its own, of a neighbour that it leans on
_CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2


class LeanKind(StrEnum):
    """What an item leans on, and how."""

    WALL = "wall"  # it stands on an edge, its top against a wall
    NEIGHBOUR = "neighbour"  # it stands on an edge, its top against another item
    PROPPED = "propped"  # one end on the floor, the other over another item


@dataclass(frozen=True, eq=False)
class LeaningStance:
    """A side of an item on which it would stand or lie if it did not lean.

    Attributes:
        R_up_item: (3, 3) orientation before any rotation; it is thin along y.
        length: m, its size in the direction in which it leans: thickness if it stands, length if it lies.
        height: m.
        is_turned: Whether it leans along x of that orientation instead of y.
    """

    R_up_item: Array
    length: float
    height: float
    is_turned: bool

    @property
    def least_angle(self) -> float:
        """Angle in rad from which it leans while it stands, as it falls back from smaller ones."""
        return float(max(DRAWN_ANGLES[0], np.arctan2(self.length, self.height) + FALLS_BACK))


def leaning_stances(item: Item, kind: LeanKind) -> list[LeaningStance]:
    """Return the sides on which an item can lean.

    Args:
        item: The item.
        kind: What it leans on.

    Returns:
        The stances; none for what is not a rigid box or would have to lean farther.
    """
    if item.shape.kind is not ShapeKind.BOX or item.folded:
        return []
    found = []
    for up in range(3):
        R = upwards(item.shape, up)
        x, y, height = np.abs(R) @ item.shape.extents
        if kind is LeanKind.PROPPED:
            if height <= y:
                lying = [
                    LeaningStance(R, float(x), float(height), is_turned=True),
                    LeaningStance(R, float(y), float(height), is_turned=False),
                ]
                found += [stance for stance in lying if height <= MOST_THICKNESS * stance.length]
        elif y >= LEAST_EDGE:
            stance = LeaningStance(R, float(y), float(height), is_turned=False)
            found += [stance] if stance.least_angle < DRAWN_ANGLES[1] else []
    return found


def lean_angle(cell_bin: Place, T_bin_item: Array) -> float:
    """Compute by how much a box in a bin leans.

    Args:
        cell_bin: The bin.
        T_bin_item: (4, 4) pose of the box.

    Returns:
        rad, the least angle between an axis of its shape and the normal of the floor below its middle.
    """
    room, x = cell_bin.room, float(T_bin_item[0, 3])
    is_slope = room.slope_from < x < room.floor_flat_from
    rise = room.floor_back - room.floor_front
    slope = rise / (room.floor_flat_from - room.slope_from) if is_slope else 0.0
    normal = np.array([-slope, 0.0, 1.0])
    upright = np.abs(T_bin_item[:3, :3].T @ normal).max() / np.linalg.norm(normal)
    return float(np.arccos(min(upright, 1.0)))


@dataclass(frozen=True, eq=False)
class _Draw:
    """What is drawn for N placements.

    Attributes:
        axis: (N,) 0 if an item leans along x of the bin, 1 along y.
        sign: (N,) 1 or -1, towards which end of that axis.
        onto: (N,) index of the neighbour that it leans on; the number of items for a wall.
        stance: (N,) index of the stance.
        share: (N, 2) 0 to 1, for the angle, or where it is propped up, and for the place along the surface.
    """

    axis: NDArray[np.intp]
    sign: Array
    onto: NDArray[np.intp]
    stance: NDArray[np.intp]
    share: Array

    @classmethod
    def random(cls, n: int, n_items: int, n_stances: int, kind: LeanKind, rng: np.random.Generator) -> _Draw:
        """Draw N of them; onto a wall never towards the mouth."""
        quarter = rng.integers(3 if kind is LeanKind.WALL else 4, size=n)
        axis, sign = np.array([1, 1, 0, 0])[quarter], np.array([1.0, -1.0, 1.0, -1.0])[quarter]
        onto = np.full(n, n_items) if kind is LeanKind.WALL else rng.integers(n_items, size=n)
        return cls(axis, sign, onto, rng.integers(n_stances, size=n), rng.random((n, 2)))

    @property
    def over_edge(self) -> Array:
        """(N,) share of the length between the end on the floor and the edge that props it up."""
        return np.asarray(OVER_EDGE[0] + self.share[:, 0] * (OVER_EDGE[1] - OVER_EDGE[0]))


@dataclass(frozen=True, eq=False)
class _Base:
    """What N placements lean on, in the bin frame.

    Attributes:
        low: (N, 3) m, lower corners of the boxes around it.
        high: (N, 3) m, upper corners.
        near: (N,) m, its nearer side along the direction of leaning.
        bears: (N,) whether it can be leaned on.
    """

    low: Array
    high: Array
    near: Array
    bears: Bools

    @classmethod
    def of(cls, room: Room, items: Sequence[Item], k: int, there: Placements, draw: _Draw) -> _Base:
        """Take what was drawn for item k: walls, or items that stand on the floor and are level on top."""
        n, rows = len(there.own), np.arange(len(there.own))
        # Only nearer sides of walls count: the lower of those beyond, the upper of that to the right.
        wall_low = np.tile([room.depth, room.y_range[1], room.floor_back], (n, 1, 1))
        wall_high = np.tile([np.inf, room.y_range[0], room.ceiling_back], (n, 1, 1))
        masses = np.array([item.mass for item in items])
        is_base = (there.own == 0.0) & there.is_level & (masses >= LEAST_MASS * items[k].mass)
        is_base[:, k] = False
        low = np.concatenate([there.boxes.low, wall_low], axis=1)[rows, draw.onto]
        high = np.concatenate([there.boxes.high, wall_high], axis=1)[rows, draw.onto]
        near = np.where(draw.sign > 0, low[rows, draw.axis], -high[rows, draw.axis])
        bears = np.concatenate([is_base, np.ones((n, 1), bool)], axis=1)[rows, draw.onto]
        return cls(low, high, near, bears)


def leaning_placements(
    cell_bin: Place,
    items: Sequence[Item],
    k: int,
    there: Placements,
    kinds: Sequence[LeanKind],
    rng: np.random.Generator,
) -> Placements:
    """Draw a leaning placement for one item in each of N packings.

    Args:
        cell_bin: The bin.
        items: Its M items.
        k: Index of the item.
        there: (N, M) placements of all in each packing.
        kinds: How it may lean; one of them is drawn.
        rng: Source of random numbers.

    Returns:
        (N,) placements.
    """
    kind = kinds[int(rng.integers(len(kinds)))]
    item, room = items[k], cell_bin.room
    stances = leaning_stances(item, kind)
    if not stances:
        return _nowhere(len(there.own))
    draw = _Draw.random(len(there.own), len(items), len(stances), kind, rng)
    base = _Base.of(room, items, k, there, draw)
    length, height, _ = _sizes(stances, draw)
    angle = _angles(room, kind, stances, draw, base)
    is_possible = base.bears & (angle >= DRAWN_ANGLES[0]) & (angle <= DRAWN_ANGLES[1])
    angle = np.where(is_possible, angle, 0.0)
    R = _leaning(stances, draw, -angle if kind is LeanKind.PROPPED else angle)
    rows, reach = np.arange(len(R)), item.shape.reach(R)
    if kind is LeanKind.PROPPED:
        u = base.near + (0.5 - draw.over_edge) * length * np.cos(angle) - 0.5 * height * np.sin(angle)
    else:
        u = base.near - TOUCH_GAP - reach[rows, draw.axis]
    centre = np.zeros((len(rows), 3))
    centre[rows, draw.axis] = draw.sign * u
    centre[rows, 1 - draw.axis] = _aside(room, kind, draw, base, reach)
    across = np.flatnonzero(draw.axis == 1)  # beside the slope of the floor, which it follows
    _, pitch = room.rest(centre[:, 0], reach[:, 0])
    R[across] = about_y(pitch[across]) @ R[across]
    reach = item.shape.reach(R)
    centre[:, 2] = _height_on_floor(room, item, R, centre) + DROP
    boxes = BoxArrays(centre - reach, centre + reach)
    is_other = np.arange(len(items)) != draw.onto[:, None]
    is_possible &= _is_inside(cell_bin, boxes)
    is_possible &= ((gap(boxes.column, there.boxes) >= GAPS[0]) | ~is_other).all(axis=1)
    if kind is LeanKind.NEIGHBOUR:
        is_possible &= base.high[:, 2] - boxes.low[:, 2] >= LEAST_BACKING * (boxes.high - boxes.low)[:, 2]
    leans_on = np.where(draw.onto < len(items), draw.onto, -1)
    level, own = np.zeros(len(rows)), np.where(is_possible, 0.0, np.inf)
    return Placements(R, centre, boxes, level, np.zeros(len(rows), bool), own, leans_on)


def _nowhere(n: int) -> Placements:
    """N placements that are impossible."""
    far = np.full((n, 3), 10.0)
    boxes = BoxArrays(far, far + 0.01)
    R = np.tile(np.eye(3), (n, 1, 1))
    return Placements(
        R, far, boxes, np.zeros(n), np.zeros(n, bool), np.full(n, np.inf), np.full(n, -1, dtype=np.intp)
    )


def _sizes(stances: Sequence[LeaningStance], draw: _Draw) -> Array:
    """Length, height and least angle (3, N) of the drawn stances, m and rad."""
    return np.array([[s.length, s.height, s.least_angle] for s in stances])[draw.stance].T


def _angles(room: Room, kind: LeanKind, stances: Sequence[LeaningStance], draw: _Draw, base: _Base) -> Array:
    """Angles (N,) of leaning in rad: drawn, or as the edge that props an item up is high; nan if too high."""
    length, _, least = _sizes(stances, draw)
    if kind is not LeanKind.PROPPED:
        return np.asarray(least + draw.share[:, 0] * (DRAWN_ANGLES[1] - least))
    edge_x = np.where(draw.axis == 0, base.low[:, 0], (base.low[:, 0] + base.high[:, 0]) / 2)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.arcsin((base.high[:, 2] - room.floor_at(edge_x)) / (draw.over_edge * length)))


def _leaning(stances: Sequence[LeaningStance], draw: _Draw, tilt: Array) -> Array:
    """Orientations (N, 3, 3): stances turned about the vertical, then tilted forwards in that direction."""
    towards = np.where(draw.axis == 0, 0.0, np.pi / 2) + np.where(draw.sign > 0, 0.0, np.pi)
    turned = np.array([0.0 if stance.is_turned else np.pi / 2 for stance in stances])[draw.stance]
    R_up = np.array([stance.R_up_item for stance in stances])[draw.stance]
    return np.asarray(about_z(towards) @ about_y(tilt) @ about_z(-turned) @ R_up)


def _aside(room: Room, kind: LeanKind, draw: _Draw, base: _Base, reach: Array) -> Array:
    """Centres (N,) along the surface: anywhere on a wall, before the middle half of a neighbour, m."""
    rows, other = np.arange(len(reach)), 1 - draw.axis
    if kind is LeanKind.WALL:
        first = np.where(other == 0, FRONT, room.y_range[0] + GAPS[0]) + reach[rows, other]
        last = np.where(other == 0, room.depth - GAPS[0], room.y_range[1] - GAPS[0]) - reach[rows, other]
    else:
        low, high = base.low[rows, other], base.high[rows, other]
        first, last = (3 * low + high) / 4, (low + 3 * high) / 4
    return np.asarray(first + draw.share[:, 1] * (last - first))


def _height_on_floor(room: Room, item: Item, R: Array, centre: Array) -> Array:
    """Heights (N,) of the centres of boxes that touch the floor with their lowest corners, m."""
    corners = np.einsum("nij,cj->nci", R, _CORNERS * item.shape.extents)
    return np.asarray((room.floor_at(centre[:, None, 0] + corners[..., 0]) - corners[..., 2]).max(axis=1))


def _is_inside(cell_bin: Place, boxes: BoxArrays) -> Bools:
    """Whether boxes are in the room, behind the mouth, and no higher than it."""
    room = cell_bin.room
    fits = (boxes.high - boxes.low)[:, 2] <= cell_bin.access.height - MOUTH_GAP
    is_below = boxes.high[:, 2] <= room.ceiling_back - CEILING_GAP
    is_short = (boxes.low[:, 0] >= FRONT) & (boxes.high[:, 0] <= room.depth - TOUCH_GAP / 2)
    is_narrow = (boxes.low[:, 1] >= room.y_range[0] + TOUCH_GAP / 2) & (
        boxes.high[:, 1] <= room.y_range[1] - TOUCH_GAP / 2
    )
    return np.asarray(fits & is_below & is_short & is_narrow)
