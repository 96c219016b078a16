"""Placement of an item that is stated: where it is to stand among others and on them, from straight above."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from pickcli.collision.free_flyer import FreeItem, FreeItemChecker
from pickcli.collision.stage_contacts import while_resting_on
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array
from pickcli.planning.pick_problem import PickProblem, StatedPlace, once_per_problem
from pickcli.planning.stages.floor_placements import HOVER
from pickcli.planning.stages.stacked_placements import all_stay
from pickcli.scene.scene import PlacedItem

LEVEL = 0.01  # m over or under its lower side, within which another's upper side counts as level with that
CLOSE = 0.03  # m seen from above, within which it may touch what is level with its lower side
BESIDE = 0.15  # m seen from above, within which it comes down beside others, from over their tops
ABOVE = 0.02  # m over their tops, where the straight line down begins
UP = np.array([0.0, 0.0, 1.0])


@once_per_problem
def pick_from_stated_place(problem: PickProblem, at: StatedPlace) -> PickProblem | Failures:
    """Return the pick that would take the target back from where it is to stand.

    It is released ``HOVER`` higher, besides the errors of its pose and of those that bear it.

    Args:
        problem: The pick.
        at: Where the target is to stand in its destination.

    Returns:
        The pick, whose ways out lead over all that stands beside; or the reasons against the place.
    """
    scene, place = problem.scene, problem.destination
    T = scene.T_world_place(place) @ at.T_place_item
    level = [other for other in _others(problem) if _is_level(other, problem.target, T)]
    if against := tuple(_against(problem, at, T, level)):
        return Failures(against)
    error = scene.bound(problem.target) + max((scene.bound(other) for other in level), default=0.0)
    T[:3, 3] += (error + HOVER) * UP
    placed, names = (
        replace(problem.target, location=place.name, T_world_item=T),
        [other.id for other in level],
    )
    touched = while_resting_on((*place.support, *names), placed.id)
    free = FreeItem(placed.item, T, scene.T_world_place(place)[:3, :3], scene.bound(problem.target))
    flying = FreeItemChecker(problem.context.model, scene, free, touched)
    if not flying.is_valid(np.zeros(6)):
        why = flying.explain(np.zeros(6))
        return Failures.of(Reason("the stated place is not free", place.name, why.detail, why.in_the_way))
    if not all_stay(scene, placed):
        return Failures.of(Reason("would fall over", place.name, f"{placed.id} at {at}, or what bears it"))
    return problem.back_from(placed, _rise(problem, placed), frozenset(names))


def _against(problem: PickProblem, at: StatedPlace, T: Array, level: list[PlacedItem]) -> Iterator[Reason]:
    """Yield the reasons against a pose (4, 4) that do not depend on what is beside it."""
    place, T_place_item = problem.destination, at.T_place_item
    reach = problem.target.item.shape.reach(T_place_item[:3, :3])
    low, high, room = T_place_item[:3, 3] - reach, T_place_item[:3, 3] + reach, place.room
    beyond = float(np.maximum(high[:2] - room.high[:2], room.low[:2] - low[:2]).max())
    if beyond > 0.0:
        yield Reason("the stated place is over the edge", place.name, f"by {1e3 * beyond:.1f} mm")
    own = _box(problem.target, T)
    is_borne = any(_gap(_box(other, other.T_world_item), own) < 0.0 for other in level)
    floor = float(room.floor_at(T_place_item[0, 3]))
    if not is_borne and low[2] - floor > LEVEL:
        z = 1e3 * (T_place_item[2, 3] - low[2] + floor)
        detail = f"{problem.target.id} at {at} stands on no item; on the floor its z would be {z:.1f} mm"
        yield Reason("nothing is below the stated place", place.name, detail)


def _others(problem: PickProblem) -> Iterator[PlacedItem]:
    here = problem.scene.in_location(problem.destination.name)
    return (other for other in here if other.id != problem.target.id)


def _is_level(other: PlacedItem, target: PlacedItem, T: Array) -> bool:
    """Whether an item is level with the lower side of another at a pose (4, 4), below it or close to it."""
    below, above = _box(other, other.T_world_item), _box(target, T)
    return abs(float(below[1][2] - above[0][2])) <= LEVEL and _gap(below, above) < CLOSE


def _rise(problem: PickProblem, placed: PlacedItem) -> float:
    """Return m by which an item is led further up than without others, over the tops of those beside it."""
    own = _box(placed, placed.T_world_item)
    boxes = [_box(other, other.T_world_item) for other in _others(problem)]
    top = max((float(box[1][2]) for box in boxes if _gap(box, own) < BESIDE), default=-np.inf)
    return max(0.0, top + ABOVE - float(own[0][2]) - problem.settings.first_stretch)


def _box(placed: PlacedItem, T: Array) -> tuple[Array, Array]:
    """Return both corners (3,) of the box around an item at a pose (4, 4), m in the world."""
    reach = placed.item.shape.reach(T[:3, :3])
    return T[:3, 3] - reach, T[:3, 3] + reach


def _gap(a: tuple[Array, Array], b: tuple[Array, Array]) -> float:
    """Return m between two boxes, given by their corners, seen from above; negative where they overlap."""
    return float(np.maximum(a[0] - b[1], b[0] - a[1])[:2].max())
