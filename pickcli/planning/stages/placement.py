"""Letting an item go: over the tote, or on the floor of a bin.

Over the tote it goes straight down between the walls, and the empty tool straight up again. Into a bin it
goes by a pick from there, backwards: what leads to an item lying there and brings it out also brings it in
and leads away from it, so the lines, their proofs and the reasons for failures are those of a pick.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pickcli.cartesian.line_following import follow_line
from pickcli.cell.place import Place
from pickcli.collision.motion_segment import Mode, MotionSegment
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array, rotation_axis_angle
from pickcli.motion.segment import SegmentKind, SegmentLimits
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.stages.bin_placements import bin_spots
from pickcli.planning.stages.grasp_motion import GraspMotion, plan_grasp_motion
from pickcli.planning.stages.tool_clearance import tool_lines
from pickcli.planning.stages.tote_placements import TotePlacement, spots
from pickcli.scene.scene import TOTE, PlacedItem, Scene
from pickcli.seeds import derived_rng

WANTED_IN_TOTE, WANTED_IN_BIN = 4, 2  # motions among which the best whole one is chosen
TOTE_COST = 2.0  # s that a metre of a spot's cost is worth
BIN_COST = 0.1  # s that the next best place is worth
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


def plan_placement(
    problem: PickProblem, chosen: GraspMotion, into: str
) -> tuple[PlaceMotion, ...] | Failures:
    """Find motions that let the item go, all proven.

    Args:
        problem: The pick.
        chosen: How the item is held.
        into: Where it is brought, the tote or a bin.

    Returns:
        The motions, the best place first; or every reason why there is none.
    """
    if into == TOTE:
        return _into_tote(problem, chosen)
    return _into_bin(problem, chosen, problem.context.cell.pod.bins[into])


def _into_tote(problem: PickProblem, chosen: GraspMotion) -> tuple[PlaceMotion, ...] | Failures:
    context, state = problem.context, chosen.grasp.tool_state
    # What is taken out of the tote no longer lies there.
    places = spots(problem.scene.without(problem.target.id), chosen.attached, state)
    if isinstance(places, Reason):
        return Failures.of(places)
    rng = derived_rng(problem.seed, "drop", problem.target.id)
    named = [c.q for c in context.cell.configurations.values() if c.kind in ("tote", "drop")]
    carrying = Mode(state, chosen.attached, problem.contacts.while_transferring())
    checker = context.checker_for(problem.scene, carrying)
    found: list[PlaceMotion] = []
    failures = Failures()
    for spot in places:
        seeds = np.vstack([chosen.end, *named, context.arm.random_seeds(rng, 4)])
        solutions = context.arm.solve(spot.above, state, seeds)
        for q in solutions[checker.are_valid(solutions)]:
            motion = _dropped(problem, spot, q, carrying)
            if not isinstance(motion, Reason):
                found.append(motion)
                break
            failures += motion
        if len(found) >= WANTED_IN_TOTE:
            break
    none = Reason("no free place in the tote", "place", f"{len(places)} spots tried")
    return tuple(found) or failures + none


def _dropped(problem: PickProblem, spot: TotePlacement, q: Array, carrying: Mode) -> PlaceMotion | Reason:
    """Down to one spot and up again, from a configuration (n,) above the tote."""
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
    return PlaceMotion(problem.scene, (place,), (depart,), TOTE_COST * spot.cost)


def _into_bin(
    problem: PickProblem, chosen: GraspMotion, cell_bin: Place
) -> tuple[PlaceMotion, ...] | Failures:
    context, target = problem.context, problem.target
    places: list[PlacedItem] = []
    failures = Failures()
    for R_bin_item in _orientations(problem):
        spots_there = bin_spots(context, problem.scene, target, R_bin_item, cell_bin)
        if isinstance(spots_there, Reason):
            failures += spots_there
        else:
            places += spots_there
    rng = derived_rng(problem.seed, "set down", target.id, cell_bin.name)
    found: list[PlaceMotion] = []
    for k, placed in enumerate(places):
        there = PickProblem(
            context, problem.scene.moved(placed), cell_bin, placed, problem.neighbours, problem.seed
        )
        if there.contacts.beside:
            failures += _too_close(there, f"place {k} in {cell_bin.name}")
            continue
        ways = tool_lines(there, chosen.grasp)
        picked = Failures.of(ways) if isinstance(ways, Reason) else plan_grasp_motion(there, ways, rng)
        if isinstance(picked, Failures):
            failures += picked
            continue
        found.append(_set_down(there, picked, BIN_COST * k))
        if len(found) >= WANTED_IN_BIN:
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


def _too_close(there: PickProblem, where: str) -> Failures:
    """What else than the floor the item would touch where it is set down."""
    items, names = frozenset(placed.id for placed in there.scene.items), sorted(there.contacts.beside)
    return Failures(tuple(Reason("too close", where, name, name if name in items else "") for name in names))


def _set_down(there: PickProblem, picked: GraspMotion, cost: float) -> PlaceMotion:
    """The segments of a pick from there, each backwards."""
    kinds = {SegmentKind.RETREAT: SegmentKind.INSERT, SegmentKind.LIFT: SegmentKind.PLACE}
    inward = tuple(segment.backwards(kinds[segment.kind]) for segment in reversed(picked.outward))
    off, *rest = (segment.backwards(SegmentKind.DEPART) for segment in reversed(picked.inward))
    # Away from the item the cup need not be as slow as it meets it.
    off = replace(off, limits=SegmentLimits(max_tool_speed=there.context.settings.approach_speed))
    return PlaceMotion(there.scene, inward, (off, *rest), cost)
