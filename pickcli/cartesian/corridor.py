"""Corridors: straight lines that take an item out of its bin, independent of the grasp.

They are found once per pick, before any grasp is tried: a buried item fails here, with the neighbour that
blocks it, and otherwise all grasps follow the same few corridors.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import chain, islice, product

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.place import Access, Place
from pickcli.cell.shapes import Shape
from pickcli.collision.free_flyer import FreeItemChecker
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array, rotation_rpy

RETREAT_DISTANCE = 0.02  # m from the mouth to the nearest point of the held item at the end
LIP_DISTANCE = 0.014  # m between the held item and a lip that it passes, if there is enough room
LEAST_LIP_DISTANCE = 0.006
LEAST_LIFT = 0.02  # m
TIGHT_MOUTH_PLAY = 0.10  # m of spare room in the mouth, below which turns of the item are tried
SIDEWAYS_OFFSETS = (0.0, 0.02, -0.02, 0.04, -0.04, 0.07, -0.07)  # m, displacements along y that are tried
MAX_CENTRING = 0.015  # m that an item moves to the side in the first stretch, towards the middle of the bin
BACKWARD_OFFSETS = (0.0, -0.02, -0.04)  # m, displacements towards the mouth that are tried
PRICES = np.array([1.0, 1.0, 0.7, 0.1, 0.1, 0.1])  # of a displacement along and about the axes, per m or rad
N_EXPLAINED = 8  # about, of the corridors if none is free, from the shortest to the longest
# shares of a way at which an explanation looks for what blocks it
EXPLAINED_SHARES = np.linspace(0.0, 1.0, 11)
ROLLS = np.radians(np.arange(2.5, 90.1, 2.5))  # about the bin's axis, tried to either side
YAWS, PITCHES = np.radians(np.arange(-24.0, 25.0, 2.0)), np.radians(np.arange(-8.0, 9.0, 1.0))  # tried


@dataclass(frozen=True, eq=False)
class Corridor:
    """Displacements (6,) of the item at the ends of first stretch, lift, and each line of the retreat.

    Each has m along the entry's axes, and rad about the entry's z, then its y, then its x axis.

    Attributes:
        first_stretch: (6,) at the end of the first stretch, in which item and support may touch.
        lift: (6,) at the end of the lift.
        retreat: At least one (6,), at the end of each line of the retreat.
    """

    first_stretch: Array
    lift: Array
    retreat: tuple[Array, ...]


@dataclass(frozen=True, eq=False)
class LiftPoses:
    """Tool poses in the world during the extraction of the item.

    Attributes:
        first_stretch: (4, 4) at the end of the first stretch, in which item and support may touch.
        lift: (4, 4) at the end of the lift.
        retreat: (4, 4) each, at the end of each line of the retreat; none if the item stays in its place.
    """

    first_stretch: Array
    lift: Array
    retreat: tuple[Array, ...]

    @classmethod
    def of(cls, poses: Array) -> LiftPoses:
        """Name the tool poses along a corridor.

        Args:
            poses: (K, 4, 4) poses in the world, in the order of ``corridor_transforms``.

        Returns:
            The poses by name.
        """
        first_stretch, lift, *retreat = poses
        return cls(first_stretch, lift, tuple(retreat))


def corridor_transforms(corridor: Corridor, T_world_entry: Array, about: Array) -> Array:
    """Return the displacements of a corridor as transforms of everything that moves with the item.

    Args:
        corridor: The corridor.
        T_world_entry: (4, 4) entry frame of the place, in whose axes the corridor is given.
        about: (3,) m in the world, centre of the item's turns.

    Returns:
        (K, 4, 4) transforms, to be multiplied from the left with a pose in the world: to the end of the first
        stretch, of the lift, and of each line of the retreat.
    """
    R = T_world_entry[:3, :3]
    d = np.array([corridor.first_stretch, corridor.lift, *corridor.retreat])
    T = np.repeat(np.eye(4)[None], len(d), axis=0)
    T[:, :3, :3] = R @ _turned(*d[:, 3:].T) @ R.T
    T[:, :3, 3] = about + d[:, :3] @ R.T - T[:, :3, :3] @ about
    return T


def corridors(
    place: Place,
    T_entry_item: Array,
    shape: Shape,
    leaving: FreeItemChecker,
    carrying: FreeItemChecker,
    first: float,
    n_most: int,
) -> tuple[Corridor, ...] | Failures:
    """Find proven corridors, the shortest first.

    Args:
        place: Place of the item.
        T_entry_item: (4, 4) pose of the item in the entry frame of the place.
        shape: Shape of the item, enlarged by its uncertainty.
        leaving: Checker of the item while it may touch its support.
        carrying: Checker of the item when it may touch nothing.
        first: m, length of the first stretch, in which touching is allowed and the item moves away from walls
            and neighbours.
        n_most: Most corridors.

    Returns:
        The corridors, at least one; or the reasons for failure: obstacles in some of those that would fit, or
        for every turn of the item why it does not fit.
    """
    options: list[Iterable[Corridor]] = []
    failures = Failures()
    half_width = float(shape.reach(T_entry_item[:3, :3])[1])
    for turns in _turns(place, T_entry_item, shape):
        reach = shape.reach(_turned(*turns) @ T_entry_item[:3, :3])
        low, high = T_entry_item[:3, 3] - reach, T_entry_item[:3, 3] + reach
        if place.access.is_from_above:
            options.append(_straight_up(place.access, low, high, turns, first))
            continue
        fitting = _options(place, low, high, turns, first, half_width)
        if isinstance(fitting, Reason):
            failures += fitting
        else:
            options.append(fitting)
    if not options:
        return failures
    tried: list[Corridor] = []

    def proven() -> Iterator[Corridor]:
        for c in chain.from_iterable(options):
            tried.append(c)
            if carrying.is_valid(c.lift) and _is_proven(c, leaving, carrying):
                yield c

    def explained() -> Iterator[Reason]:
        # The shortest ones may all be blocked by a wall, and only longer ones by a neighbour that can move.
        for c in tried[:: 1 + len(tried) // N_EXPLAINED]:
            yield _explained(c, leaving, carrying)

    return tuple(islice(proven(), n_most)) or Failures((explained,))


def _is_proven(c: Corridor, leaving: FreeItemChecker, carrying: FreeItemChecker) -> bool:
    return carrying.is_valid_path(np.stack([c.first_stretch, c.lift, *c.retreat])) and leaving.is_valid_path(
        np.stack([np.zeros(6), c.first_stretch])
    )


def _explained(c: Corridor, leaving: FreeItemChecker, carrying: FreeItemChecker) -> Reason:
    """Explain what blocks a corridor, and where it is worst of sampled poses; else the blocked edge."""
    way, along = np.stack([c.lift, *c.retreat]), EXPLAINED_SHARES[1:]
    shares = np.linspace(0.0, 1.0, len(way))
    out = np.column_stack([np.interp(along, shares, x) for x in way.T])
    while_leaving, while_carrying = (
        np.outer(along, c.first_stretch),
        np.vstack([c.first_stretch, c.lift, out]),
    )
    sampled = np.vstack([while_leaving, while_carrying])
    is_valid = np.append(leaving.are_valid(while_leaving), carrying.are_valid(while_carrying))
    clearances = np.append(leaving.clearances(while_leaving), carrying.clearances(while_carrying))
    if is_valid.all():
        first = np.stack([np.zeros(6), c.first_stretch])
        path = np.stack([c.first_stretch, c.lift, *c.retreat])
        why = carrying.explain_path(path) if leaving.is_valid_path(first) else leaving.explain_path(first)
        return Reason("no way out", "lift", why.detail, why.in_the_way)
    worst = int(np.argmin(np.where(is_valid, np.inf, clearances)))
    where = (
        *(f"{100 * s:.0f} % along the first stretch" for s in along),
        "after the first stretch",
        "at the end of the lift",
        *(f"{100 * s:.0f} % along the retreat" for s in along),
    )
    why = (leaving if worst < len(while_leaving) else carrying).explain(sampled[worst])
    return Reason("no way out", "lift", f"{why.detail}, {where[worst]}", why.in_the_way)


def _turned(yaw: float | Array, pitch: float | Array, roll: float | Array = 0.0) -> Array:
    """Return the rotations (..., 3, 3) by yaw about z after pitch about y after roll about x, broadcast."""
    rolls, pitches, yaws = np.broadcast_arrays(roll, pitch, yaw)
    return np.moveaxis(rotation_rpy(rolls, pitches, yaws), (0, 1), (-2, -1))


def _turns(place: Place, T_entry_item: Array, shape: Shape) -> list[tuple[float, float, float]]:
    """Return turns (yaw, pitch, roll) to try: none, and those that make the item narrower or lower."""
    R = T_entry_item[:3, :3]
    if place.access.is_from_above:
        return [(0.0, 0.0, 0.0), *_rolls(place, R, shape, 0.0)]
    widths = shape.reach(_turned(YAWS, 0.0) @ R)[:, 1]
    yaw = float(YAWS[np.argmin(widths)]) if _is_tighter(widths, place.access.width) else 0.0
    heights = shape.reach(_turned(yaw, PITCHES) @ R)[:, 2]
    flattest = float(PITCHES[np.argmin(heights)])
    pitch = flattest if _is_tighter(heights, place.access.height) else 0.0
    level = [(0.0, 0.0, 0.0), (yaw, 0.0, 0.0), (yaw, pitch, 0.0)]
    return list(dict.fromkeys([*level, *_rolls(place, R, shape, flattest)]))


def _rolls(place: Place, R: Array, shape: Shape, flattest: float) -> list[tuple[float, float, float]]:
    """Return the least roll to either side with which an item fits through the mouth, if it does not without.

    Args:
        place: Place of the item.
        R: (3, 3) its orientation in the entry frame.
        shape: Shape of the item, enlarged by its uncertainty.
        flattest: rad, the pitch with which the item is lowest, which is tried as well.
    """
    mouth = np.array([place.access.width, place.access.height]) - 2 * LEAST_LIP_DISTANCE

    def fit(pitch: float, rolls: Array) -> NDArray[np.bool_]:
        """Whether the item fits (N,) with each of N rolls."""
        return np.asarray((2 * shape.reach(_turned(0.0, pitch, rolls) @ R)[:, 1:] <= mouth).all(axis=1))

    if fit(0.0, np.zeros(1))[0]:
        return []
    found = []
    for pitch, side in product(dict.fromkeys((0.0, flattest)), (1.0, -1.0)):
        fitting = np.flatnonzero(fit(pitch, side * ROLLS))
        found += [(0.0, pitch, side * float(ROLLS[k])) for k in fitting[:1].tolist()]
    return found


def _is_tighter(halves: Array, mouth: float) -> bool:
    """Whether the best turn is a relevant gain: half extents (N,) over turns, in the middle without one."""
    unturned = halves[len(halves) // 2]
    return bool(unturned - halves.min() > 0.003 and mouth - 2 * unturned < TIGHT_MOUTH_PLAY)


def _options(
    place: Place,
    low: Array,
    high: Array,
    turns: tuple[float, float, float],
    first: float,
    half_width: float,
) -> Iterator[Corridor] | Reason:
    """Return corridors that fit through the mouth, shortest first; lazily, because few are needed.

    Args:
        place: Place of the item.
        low: (3,) m, lower corner in the entry frame of the box around the turned item.
        high: (3,) m, upper corner of that box.
        turns: rad, yaw, pitch and roll of the item.
        first: m, length of the first stretch.
        half_width: m, of the item without turns.
    """
    play = np.array([place.access.width, place.access.height]) - (high - low)[1:]
    if play.min() < 2 * LEAST_LIP_DISTANCE:
        return _too_large(place.access, low, high)
    side, above = np.minimum(LIP_DISTANCE, play / 2)
    half = place.access.width / 2 - side
    least = float(np.clip(0.0, -half - low[1], half - high[1]))
    heights = _heights(max(above - low[2], LEAST_LIFT), place.access.height - above - high[2])
    dz, dx, dy = np.array([*product(heights, BACKWARD_OFFSETS, SIDEWAYS_OFFSETS)]).T
    aside = least + dy
    fits = (-half - 1e-9 <= low[1] + aside) & (high[1] + aside <= half + 1e-9)
    moves = np.column_stack([dx, aside, dz, np.tile(turns, (len(dz), 1))])[fits]
    moves = moves[np.lexsort((*moves.T[::-1], np.abs(moves) @ PRICES))]
    to_middle = float(
        np.clip(sum(place.room.y_range) / 2 - (low[1] + high[1]) / 2, -MAX_CENTRING, MAX_CENTRING)
    )
    straight = (_corridor(d, float(high[0]), first) for d in moves)
    return chain.from_iterable(_rolling(c, half_width, to_middle) for c in straight)


def _straight_up(
    access: Access, low: Array, high: Array, turns: tuple[float, float, float], first: float
) -> list[Corridor]:
    """Return corridors out of a place that is open above, the least sideways motion first.

    What lies askew may pass the walls although the box around it is wider than the mouth: it is then led up
    straight, and up the middle.

    Args:
        access: The way into the place.
        low: Lower corner (3,) of the box around the turned item, in the entry frame, m.
        high: Upper corner (3,).
        turns: rad, yaw, pitch and roll of the item.
        first: m, length of the first stretch.
    """
    lowest = np.array([-access.width / 2, 0.0]) - low[1:]
    highest = np.array([access.width / 2, access.height]) - high[1:]
    moves = [np.array(d) for d in product(*map(_aside, lowest.tolist(), highest.tolist()))]
    moves.sort(key=lambda d: (float(np.abs(d).sum()), tuple(d)))
    found = []
    for d in moves:
        aside = float(np.linalg.norm(d))
        part = min(aside, 0.6 * first)
        rise = float(np.sqrt(first**2 - part**2))
        out = min(-high[0] - RETREAT_DISTANCE, -rise - LEAST_LIFT)
        first_stretch = np.array([-rise, *(d * (part / aside if aside > 0.0 else 0.0)), 0.0, 0.0, 0.0])
        lift, away = (np.array([x, *d, *turns]) for x in (-rise - LEAST_LIFT, out))
        found.append(Corridor(first_stretch, lift, (away,)))
    return found


def _aside(lowest: float, highest: float) -> list[float]:
    """Return displacements in m along one side of a mouth that are tried.

    lowest: at which the box around the item touches one edge of the mouth. highest: the same at the other
    """
    play = highest - lowest
    if play < 2 * LEAST_LIP_DISTANCE:
        return [0.0, (lowest + highest) / 2]
    side = min(LIP_DISTANCE, play / 2)
    least = float(np.clip(0.0, lowest + side, highest - side))
    tried = (least + offset for offset in SIDEWAYS_OFFSETS)
    return [d for d in tried if lowest + side - 1e-9 <= d <= highest - side + 1e-9]


def _too_large(access: Access, low: Array, high: Array) -> Reason:
    size = " x ".join(f"{e * 1e3:.0f}" for e in (high - low)[1:])
    mouth = f"{access.width * 1e3:.0f} x {access.height * 1e3:.0f}"
    return Reason("does not fit through the mouth", "lift", f"{size} mm wide and tall, mouth {mouth} mm")


def _heights(need: float, most: float) -> list[float]:
    """Return lift heights to try: just over the lip, half-way, as high as the mouth allows."""
    heights = [need, (need + most) / 2, most]
    return [h for i, h in enumerate(heights) if i == 0 or h > heights[i - 1] + 0.01]


def _corridor(lift: Array, front: float, first: float) -> Corridor:
    """Build the corridor over a lift (6,); ``front``: greatest x of the item in the entry frame.

    In the first stretch it turns in proportion to its sideways motion, or to its rise, if it only rises.
    """
    aside = float(np.hypot(lift[0], lift[1]))
    part = min(aside, 0.6 * first)
    first_stretch = lift * (part / aside if aside > 0.0 else 0.0)
    first_stretch[2] = min(lift[2], float(np.sqrt(first**2 - part**2)))
    first_stretch[3:] = lift[3:] * (part / aside if aside > 0.0 else first_stretch[2] / lift[2])
    out = np.array([-(front + lift[0] + RETREAT_DISTANCE), *np.zeros(5)])
    return Corridor(first_stretch, lift, (lift + np.minimum(out, 0.0),))


def _rolling(corridor: Corridor, half_width: float, to_middle: float) -> list[Corridor]:
    """Return the corridor; if it rolls, also variants that roll less at first, so that no side sinks.

    Variants for items that hardly fit move to the middle of the bin first, and to the side only after the
    roll.

    Args:
        corridor: The corridor.
        half_width: m, of the item without turns.
        to_middle: m along y to the middle of the bin.
    """
    lift, first = corridor.lift, corridor.first_stretch
    if lift[5] == 0.0:
        return [corridor]
    level = float(np.arcsin(min(1.0, first[2] / half_width)))
    rolls = dict.fromkeys((float(lift[5]), float(np.clip(lift[5], -level, level)), 0.0))
    found = [replace(corridor, first_stretch=np.array([*first[:5], r])) for r in rolls]
    up = np.array([0.0, to_middle, *lift[2:]])
    found += [
        Corridor(np.array([0.0, to_middle, first[2], 0.0, 0.0, r]), up, (lift, *corridor.retreat))
        for r in rolls
    ]
    return found
