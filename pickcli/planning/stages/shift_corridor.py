"""Way of an item that is moved within its place: lifted a little, carried aside, and put down on the floor.

It is found for the item as a free flyer, before any grasp is tried.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from pickcli.cartesian.corridor import Corridor, corridor_transforms
from pickcli.collision.free_flyer import FreeItemChecker
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array, inverse, rotation_axis_angle
from pickcli.planning.pick_problem import PickProblem, Shift, ShiftCorridor
from pickcli.planning.stages.extraction import extraction_of
from pickcli.planning.stages.target_check import check_target

HEIGHTS = (0.008, 0.02, 0.035)  # m that the item is lifted, besides the slope of the floor
RELEASE_GAP = 0.0015  # m that the item is higher over the floor at the release than where it was taken
LONGEST = 0.3  # m
LEAST, LEAST_TURN = 0.005, np.radians(2.0)  # m and rad: a shift by less is none
NEARER = 0.0005  # m that the item may end nearer to a solid that it was near before
MARGIN = 0.95  # share of the longest first stretch that is used: the tool moves farther if the item turns


def shift_corridor(problem: PickProblem, by: Shift) -> ShiftCorridor | Failures:
    """Find a way of the target to another pose on the floor of its place.

    Args:
        problem: The pick of the target, into its own place.
        by: The requested shift.

    Returns:
        The way with the least lift, or the reasons why there is none.
    """
    against = Failures((*_impossible(problem, by), *check_target(problem).reasons))
    if against.reasons:
        return against
    end = _displacement(problem, by)
    T = corridor_transforms(Corridor(end, end, ()), problem.T_world_entry, problem.target.T_world_item[:3, 3])
    back = problem.back_from(replace(problem.target, T_world_item=T[0] @ problem.target.T_world_item))
    if (against := Failures(tuple(_against_end(problem, back)))).reasons:
        return against
    leaving, carrying = extraction_of(problem).leaving, extraction_of(problem).carrying
    coming, failures = extraction_of(back).leaving, Failures()
    for lifted, over in _lifts(problem, end):
        lines = [(leaving, np.zeros(6), lifted), (coming, _relative(over, end), np.zeros(6))]
        if lifted is not over:
            lines.append((carrying, lifted, over))
        blocked = next(((c, a, b) for c, a, b in lines if not c.is_valid_path(np.stack([a, b]))), None)
        if blocked is None:
            return ShiftCorridor(by, lifted, over, back.target)
        failures += _no_room(*blocked, problem.place.name)
    return failures


def _impossible(problem: PickProblem, by: Shift) -> Iterator[Reason]:
    """Yield the reasons against a shift that do not depend on the item's surroundings."""
    place, target = problem.place, problem.target
    length = float(np.hypot(by.x, by.y))
    if length > LONGEST or (length < LEAST and abs(by.turn) < LEAST_TURN):
        limits = f"{by}; possible are {1e3 * LEAST:.0f} to {1e3 * LONGEST:.0f} mm"
        yield Reason("no such shift", place.name, limits)
    if place.is_open_box:
        yield Reason("no such shift", place.name, "items in an open box are not set down on its floor")
        return
    for name in problem.contacts.supports.graph.carriers(target.id):
        if name not in place.support:
            yield Reason("no such shift", place.name, f"{target.id} lies on {name}, not on the floor")


def _displacement(problem: PickProblem, by: Shift) -> Array:
    """Return the displacement (6,) in the entry frame to the release, parallel to the floor there."""
    room, shape = problem.place.room, problem.target.item.shape
    T = inverse(problem.scene.T_world_place(problem.place)) @ problem.target.T_world_item
    turned = rotation_axis_angle((0.0, 0.0, 1.0), by.turn)
    above = shape.reach(T[:3, :3])[2]
    half = np.array([shape.reach(T[:3, :3])[0], shape.reach(turned @ T[:3, :3])[0]])
    x = np.array([T[0, 3], T[0, 3] + by.x])
    _, pitch = room.rest(x, half)
    height, pitch = room.rest(x - above * np.sin(pitch), half)
    rise = float(np.diff(height + above * np.cos(pitch))[0])
    before, after = (rotation_axis_angle((0.0, 1.0, 0.0), float(p)) for p in pitch)
    R_entry_place = problem.place.T_place_entry[:3, :3].T
    R = R_entry_place @ after @ turned @ before.T @ R_entry_place.T
    moved = R_entry_place @ (by.x, by.y, rise + RELEASE_GAP)
    return np.array([*moved, *Rotation.from_matrix(R).as_euler("ZYX")])


def _relative(d: Array, end: Array) -> Array:
    """Return a displacement (6,) as seen from the item at the end of its way."""
    R = Rotation.from_euler("ZYX", d[3:]) * Rotation.from_euler("ZYX", end[3:]).inv()
    return np.array([*(d - end)[:3], *R.as_euler("ZYX")])


def _against_end(problem: PickProblem, back: PickProblem) -> Iterator[Reason]:
    """Yield the reasons against the item's pose at the end; ``back`` is the pick from there."""
    place, target = problem.place, back.target
    T = inverse(problem.scene.T_world_place(place)) @ target.T_world_item
    front = float(T[0, 3] - target.item.shape.reach(T[:3, :3])[0]) - problem.uncertainty
    if not place.access.is_from_above and front < 0.0:
        yield Reason("no such shift", place.name, f"up to {-1e3 * front:.0f} mm out of the mouth")
    before, after = problem.contacts.near, back.contacts.near
    items = {placed.id for placed in problem.scene.items}
    for name in sorted(back.contacts.near_off_floor):
        if name not in before or after[name].gap < before[name].gap - NEARER:
            yield Reason("too close", place.name, name, name if name in items else "")
    if not (set(place.support) & after.keys() and back.contacts.supports.balance.stays(target.id)):
        yield Reason("would fall over or roll", place.name, f"{target.id} at the end")


def _lifts(problem: PickProblem, end: Array) -> Iterator[tuple[Array, Array]]:
    """Yield displacements (6,) at the end of the lift and over the end; the same one on a short way."""
    up, first = problem.T_world_entry[2, :3], problem.settings.first_stretch
    length = max(float(np.linalg.norm(end[:3])), LEAST)
    for height in HEIGHTS:
        lift = np.array([*(height * up), 0.0, 0.0, 0.0])
        most = MARGIN * float(np.sqrt(first**2 - height**2)) / length
        if most >= 0.5:
            middle = 0.5 * end + lift
            yield middle, middle
        for share in (min(most, 0.4), 0.0):
            yield share * end + lift, (1.0 - share) * end + lift


def _no_room(checker: FreeItemChecker, start: Array, end: Array, where: str) -> Failures:
    """Explain what blocks a line from a displacement (6,) to another; evaluated lazily."""

    def blocking() -> Iterator[Reason]:
        why = checker.explain_path(np.stack([start, end]))
        yield Reason("no room to shift", where, why.detail, why.in_the_way)

    return Failures((blocking,))
