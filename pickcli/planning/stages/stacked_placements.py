"""Placements for setting an item down on another one: on a level upper side, where all keep their balance.

An item's shape is the box around it, and its upper side need not be there: that of a brush or of a dumbbell
is not. As with grasps, the sides that are taken to exist are those on which a cup seals.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from pickcli.cell.place import Place
from pickcli.cell.shapes import ShapeKind
from pickcli.collision.free_flyer import FreeItem, FreeItemChecker
from pickcli.collision.stage_contacts import while_resting_on
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array, inverse, least_turn, levelled, pose, transform_points
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.stages.floor_placements import FROM_MOUTH, HOVER
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.statics.balance import FREE_SLENDERNESS
from pickcli.statics.landing import DIRECTIONS, stays_on
from pickcli.statics.supports import supports_of

STEP = 0.02  # m between tried placements
LEVEL = np.cos(np.radians(8.0))  # of the angle of an upper side to the horizontal: floors slope by 5 degrees
UP = np.array([0.0, 0.0, 1.0])


def stacked_placements(
    context: PlanningContext,
    scene: Scene,
    placed: PlacedItem,
    R_place_item: Array,
    place: Place,
    n_most: int = 8,
    hover: float = HOVER,
) -> tuple[PlacedItem, ...] | Failures:
    """Find placements of an item on top of items in a place.

    Args:
        context: The cell, its models and its precomputed files.
        scene: Poses as perceived.
        placed: The item at its current pose.
        R_place_item: (3, 3) its orientation at the destination, before it is levelled.
        place: The destination.
        n_most: Most placements.
        hover: m over the item below, besides the errors of both poses.

    Returns:
        The item at each placement, the lowest first; or the reasons for failure.
    """
    R = levelled(R_place_item)
    reach, shape = placed.item.shape.reach(R), placed.item.shape
    no_top = Reason("no level top", place.name, f"no item there bears {placed.id}")
    is_slender = float(reach[:2].min()) < FREE_SLENDERNESS * float(reach[2])
    if is_slender or placed.item.can_roll(R) or shape.kind is ShapeKind.SPHERE:
        return Failures.of(no_top)
    free: list[PlacedItem] = []
    for below in scene.in_location(place.name):
        top = _top(below, scene.T_world_place(place))
        if top is not None:
            gap = scene.bound(placed) + scene.bound(below) + hover
            free += _free_on(context, scene, replace(placed, location=place.name), R, below, top, gap)
    free.sort(key=lambda at: round(float(at.T_world_item[2, 3]), 3))
    staying = tuple(islice((at for at in free if all_stay(scene, at)), n_most))
    return staying or Failures.of(no_top)


@dataclass(frozen=True)
class _Top:
    """A level upper side, in the frame of the place.

    middle: (3,) m. normal: (3,). sides: (2, 3) m, from the middle to two of its edges. radius: m, if round
    """

    middle: Array
    normal: Array
    sides: Array
    radius: float

    def reaches(self, at: Array) -> Array:
        """Return how far in m its edge is from a point (3,) over it, along each of ``DIRECTIONS``."""
        across = np.minimum(np.abs(DIRECTIONS @ self.sides.T).sum(axis=1), self.radius)
        return np.asarray(DIRECTIONS @ (self.middle - at) + across)


def _top(below: PlacedItem, T_world_place: Array) -> _Top | None:
    """Return the upper side of an item, if it is flat, nearly level and there."""
    item, T = below.item, inverse(T_world_place) @ below.T_world_item
    k = int(np.argmax(np.abs(T[2, :3])))
    up = float(np.sign(T[2, k]))
    is_flat = item.shape.kind is ShapeKind.BOX or (item.shape.kind is ShapeKind.CYLINDER and k == 2)
    face = ("+" if up > 0.0 else "-") + "xyz"[k]
    if not is_flat or up * T[2, k] < LEVEL or item.seals[face] <= 0.0:
        return None
    half = item.shape.extents / 2
    low, high = np.maximum(item.area(face)[0], -half), np.minimum(item.area(face)[1], half)
    middle = (low + high) / 2
    middle[k] = up * half[k]
    sides = np.array([(high - low)[i] / 2 * T[:3, i] for i in range(3) if i != k])
    radius = item.shape.size[0] if item.shape.kind is ShapeKind.CYLINDER else np.inf
    return _Top(transform_points(T, middle), up * T[:3, k], sides, radius)


def _free_on(
    context: PlanningContext,
    scene: Scene,
    placed: PlacedItem,
    R: Array,
    below: PlacedItem,
    top: _Top,
    gap: float,
) -> Iterator[PlacedItem]:
    """Yield an item at all free placements on one item, those over its middle first.

    R: (3, 3) its orientation, levelled. top: upper side of the other. gap: m over it, where this is let go
    """
    place = scene.cell.places[placed.location]
    T_world_place, bound = scene.T_world_place(place), scene.bound(placed)
    half = float(placed.item.shape.reach(R)[2])
    R = least_turn(UP, top.normal) @ R
    free = FreeItem(placed.item, T_world_place @ pose(R=R), T_world_place[:3, :3], bound)
    flying = FreeItemChecker(
        context.model, scene, free, while_resting_on((*place.support, below.id), placed.id)
    )
    steps = [int(np.ceil(np.linalg.norm(side) / STEP)) for side in top.sides]
    shares = np.meshgrid(*(np.linspace(-1.0, 1.0, 2 * n + 1) for n in steps))
    spots = np.stack(shares, axis=-1).reshape(-1, 2)
    depth = float(placed.item.shape.reach(R)[0])
    own, error = placed.item.shape.reach(DIRECTIONS @ R), scene.bound(placed) + scene.bound(below)
    for spot in spots[np.argsort(np.linalg.norm(spots, axis=1), kind="stable")]:
        over = top.middle + spot @ top.sides
        at = over + (half + gap) * top.normal
        if not stays_on(placed.item.shape, R, np.minimum(top.reaches(over), own), error, gap):
            continue
        if at[0] - depth >= FROM_MOUTH and flying.is_valid(np.concatenate([at, np.zeros(3)])):
            yield replace(placed, T_world_item=T_world_place @ pose(at, R=R))


def all_stay(scene: Scene, placement: PlacedItem) -> bool:
    """Tell whether an item stays where it is released, and so do all others in its place, with it on them.

    Args:
        scene: Poses as perceived.
        placement: The item where it is released.

    Returns:
        Whether they do; what did not keep its balance before does not count.
    """
    beside = [p for p in scene.in_location(placement.location) if p.id != placement.id]
    before = supports_of(replace(scene, items=tuple(beside))).balance
    after = supports_of(replace(scene, items=(*beside, placement))).balance
    return after.stays(placement.id) and all(after.stays(p.id) or not before.stays(p.id) for p in beside)
