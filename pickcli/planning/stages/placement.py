"""Letting an item go at its destination, by the way that leads into that.

From above it goes straight down between the walls, and the empty tool straight up again. From the front it
goes by a pick from there, backwards: what leads to an item lying there and brings it out also brings it in
and leads away from it, so the lines, their proofs and the reasons for failures are those of a pick.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pickcli.cartesian.line_following import follow_line
from pickcli.collision.motion_segment import Mode, MotionSegment
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array, rotation_axis_angle
from pickcli.motion.segment import SegmentKind, SegmentLimits
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.stages.drop_placements import DropPlacement, drop_placements
from pickcli.planning.stages.floor_placements import floor_placements
from pickcli.planning.stages.grasp_motion import GraspMotion, plan_grasp_motion
from pickcli.planning.stages.tool_clearance import tool_lines
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.seeds import derived_rng

WANTED_FROM_ABOVE, WANTED_FROM_FRONT = 4, 2  # motions among which the best whole one is chosen
DROP_COST = 2.0  # s that a metre of a drop's cost is worth
NEXT_COST = 0.1  # s that the next best place is worth
QUARTER_TURNS = (0.0, np.pi / 2, np.pi, -np.pi / 2)  # rad


@dataclass(frozen=True, eq=False)
class PlaceMotion:
    """One way to let the item go. Each segment starts where the one before ends.

    Attributes:
        scene: The scene when the item has been let go.
        inward: With the item, to the release.
        away: With the empty tool, in that scene.
        cost: s that a better place would be worth.
    """

    scene: Scene
    inward: tuple[MotionSegment, ...]
    away: tuple[MotionSegment, ...]
    cost: float

    @property
    def start(self) -> Array:
        """Configuration (n,) in which the transfer arrives."""
        return self.inward[0].start


def plan_placement(problem: PickProblem, chosen: GraspMotion) -> tuple[PlaceMotion, ...] | Failures:
    """Find motions that let the item go at its destination, all proven.

    Args:
        problem: The pick.
        chosen: How the item is held.

    Returns:
        The motions, the best placement first; or every reason why there is none.
    """
    if problem.destination.access.is_from_above:
        return _drops(problem, chosen)
    return _set_downs(problem, chosen)


def _drops(problem: PickProblem, chosen: GraspMotion) -> tuple[PlaceMotion, ...] | Failures:
    """Motions that drop the item from above."""
    context, state, destination = problem.context, chosen.grasp.tool_state, problem.destination
    # What is taken out of its destination no longer lies there.
    without = problem.scene.without(problem.target.id)
    placements = drop_placements(without, destination, chosen.attached, state)
    if isinstance(placements, Failures):
        return placements
    rng = derived_rng(problem.seed, "drop", problem.target.id)
    carrying = Mode(state, chosen.attached, problem.contacts.while_transferring())
    named = context.configurations_at(destination)
    found: list[PlaceMotion] = []
    failures = Failures()
    for spot in placements:
        seeds = np.vstack([chosen.end, *named, context.arm.random_seeds(rng, 4)])
        motion = _dropped(problem, spot, seeds, carrying)
        if isinstance(motion, Failures):
            failures += motion
            continue
        found.append(motion)
        if len(found) >= WANTED_FROM_ABOVE:
            break
    none = Reason(f"no free place in the {destination.name}", "place", f"{len(placements)} spots tried")
    return tuple(found) or failures + none


def _dropped(
    problem: PickProblem, spot: DropPlacement, seeds: Array, carrying: Mode
) -> PlaceMotion | Failures:
    """Down to one placement and up again, from the first of the arm's solutions above it that can."""
    context, checker = problem.context, problem.context.checker_for(problem.scene, carrying)
    solutions = context.arm.solve(spot.above, carrying.tool_state, seeds)
    if len(solutions) == 0:
        return Failures.of(Reason("no inverse-kinematics solution", "place"))
    are_valid = checker.are_valid(solutions)
    if not are_valid.any():
        return Failures.of(checker.explain(solutions[0]).at("place"))
    failures = Failures()
    for q in solutions[are_valid]:
        motion = _lowered(problem, spot, q, carrying)
        if not isinstance(motion, Reason):
            return motion
        failures += motion
    return failures


def _lowered(problem: PickProblem, spot: DropPlacement, q: Array, carrying: Mode) -> PlaceMotion | Reason:
    """Down to one placement and up again, from a configuration (n,) above it."""
    context, state = problem.context, carrying.tool_state
    checker = context.checker_for(problem.scene, carrying)
    down = follow_line(context.arm, checker, spot.above, spot.release, state, q, "place")
    if isinstance(down, Reason):
        return down
    limits = SegmentLimits(max_tool_speed=context.settings.place_speed)
    place = MotionSegment(SegmentKind.PLACE, down, limits, mode=carrying)
    # The way up is the way down without the item: a part of the volume that was just proven free.
    empty = Mode(state, None, problem.contacts.after_dropping())
    depart = replace(place.backwards(SegmentKind.DEPART), mode=empty)
    return PlaceMotion(problem.scene, (place,), (depart,), DROP_COST * spot.cost)


def _set_downs(problem: PickProblem, chosen: GraspMotion) -> tuple[PlaceMotion, ...] | Failures:
    """Motions that set the item down on the floor of its destination, from the front."""
    context, target, destination = problem.context, problem.target, problem.destination
    placements: list[PlacedItem] = []
    failures = Failures()
    for R_place_item in _orientations(problem):
        there = floor_placements(context, problem.scene, target, R_place_item, destination)
        if isinstance(there, Failures):
            failures += there
        else:
            placements += there
    rng = derived_rng(problem.seed, "set down", target.id, destination.name)
    found: list[PlaceMotion] = []
    for k, placed in enumerate(placements):
        back = problem.back_from(placed)
        if back.contacts.beside:
            failures += _too_close(back, f"place {k} in {destination.name}")
            continue
        ways = tool_lines(back, chosen.grasp)
        picked = ways if isinstance(ways, Failures) else plan_grasp_motion(back, ways, rng)
        if isinstance(picked, Failures):
            failures += picked
            continue
        found.append(_set_down(back, picked, NEXT_COST * k))
        if len(found) >= WANTED_FROM_FRONT:
            break
    return tuple(found) or failures


def _orientations(problem: PickProblem) -> list[Array]:
    """How the target may stand in a bin, (3, 3) each: as it stands where it is taken from.

    What is taken out of a place from above by its upper side goes into a bin with that side to the front, and
    may be turned about the way in.
    """
    R_entry_item = problem.T_entry_item[:3, :3]
    if not problem.place.access.is_from_above:
        return [R_entry_item]
    return [rotation_axis_angle((1.0, 0.0, 0.0), turn) @ R_entry_item for turn in QUARTER_TURNS]


def _too_close(back: PickProblem, where: str) -> Failures:
    """What else than the floor the item would touch where it is set down."""
    items, names = frozenset(placed.id for placed in back.scene.items), sorted(back.contacts.beside)
    return Failures(tuple(Reason("too close", where, name, name if name in items else "") for name in names))


def _set_down(back: PickProblem, picked: GraspMotion, cost: float) -> PlaceMotion:
    """The segments of a pick from there, each backwards."""
    kinds = {SegmentKind.RETREAT: SegmentKind.INSERT, SegmentKind.LIFT: SegmentKind.PLACE}
    inward = tuple(segment.backwards(kinds[segment.kind]) for segment in reversed(picked.outward))
    off, *rest = (segment.backwards(SegmentKind.DEPART) for segment in reversed(picked.inward))
    # Away from the item the cup need not be as slow as it meets it.
    off = replace(off, limits=SegmentLimits(max_tool_speed=back.context.settings.approach_speed))
    return PlaceMotion(back.scene, inward, (off, *rest), cost)
