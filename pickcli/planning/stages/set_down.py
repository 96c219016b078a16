"""Motions that set an item down on the floor of a place: picks from where it is to lie, reversed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.cell.tool import ToolState
from pickcli.errors import Failures, Reason
from pickcli.motion.plan import Grasp
from pickcli.motion.segment import SegmentKind, SegmentLimits
from pickcli.planning.pick_motion import GraspMotion, PlaceMotion
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.stages.extraction import CorridorSet, extraction_of
from pickcli.planning.stages.grasp_motion import arm_seeds, plan_grasp_motion
from pickcli.planning.stages.picks_back import picks_back
from pickcli.planning.stages.tool_clearance import tool_lines
from pickcli.seeds import derived_rng

N_MOTIONS = 2  # motions from which the best is chosen
NEXT_COST = 0.1  # s of additional cost of each next placement


def plan_set_downs(
    problem: PickProblem, chosen: GraspMotion, tool_state: ToolState
) -> tuple[PlaceMotion, ...] | Failures:
    """Find motions that set the item down on the floor of its destination.

    A pick from there is planned and reversed: a motion that leads to an item lying there and takes it out
    also brings it in, so lines, proofs and reasons for failures are those of a pick.

    Args:
        problem: The pick.
        chosen: Motion of the chosen grasp.
        tool_state: State of the tool in which the item is set down.

    Returns:
        The motions, the best placement first; or every reason for failure.
    """
    target, destination = problem.target, problem.destination
    backs, failures = picks_back(problem, chosen.grasp, tool_state)
    grasp = replace(chosen.grasp, tool_state=tool_state)
    rng = derived_rng(problem.seed, "set down", target.id, destination.name)
    found: list[PlaceMotion] = []
    for k, back in enumerate(backs):
        if too_close := back.contacts.near_off_floor - _leant_on(back):
            failures += _too_close(back, too_close, f"place {k} in {destination.name}")
            continue
        picked = _picked_back(back, grasp, rng)
        if isinstance(picked, Failures):
            failures += picked
            continue
        found.append(set_down(back, picked, NEXT_COST * k))
        if len(found) >= N_MOTIONS:
            break
    return tuple(found) or failures


def _picked_back(back: PickProblem, grasp: Grasp, rng: np.random.Generator) -> GraspMotion | Failures:
    """Plan the lines of a pick from where the item is set down, with the same grasp."""
    ways_out = extraction_of(back).transforms(CorridorSet.FEW)
    if isinstance(ways_out, Failures):
        return ways_out
    lines = tool_lines(back, grasp, ways_out)
    if isinstance(lines, Failures):
        return lines
    return plan_grasp_motion(back, lines, back.context.cell.robot.tool.contact_speed, arm_seeds(back, rng))


def _leant_on(back: PickProblem) -> frozenset[str]:
    """Return names of solids that the item is set down on, or needs for balance: it may touch them."""
    balance, item = back.contacts.supports.balance, back.target.id
    if not back.contacts.near_off_floor or not balance.stays(item):
        return back.level_with
    needed = {name for name in back.contacts.near_off_floor if not balance.stays(item, {name})}
    return back.level_with | needed


def _too_close(back: PickProblem, names: frozenset[str], where: str) -> Failures:
    """Return a reason for each solid, except floor and those it leans on, that the item would touch."""
    items = frozenset(placed.id for placed in back.scene.items)
    return Failures(
        tuple(Reason("too close", where, name, name if name in items else "") for name in sorted(names))
    )


def set_down(back: PickProblem, picked: GraspMotion, cost: float) -> PlaceMotion:
    """Reverse the segments of a pick from a placement.

    Args:
        back: The pick of the item from there.
        picked: Its motion inside the place.
        cost: s, penalty of the placement.

    Returns:
        The motion that sets the item down there.
    """
    kinds = {SegmentKind.RETREAT: SegmentKind.INSERT, SegmentKind.LIFT: SegmentKind.PLACE}
    inward = tuple(segment.backwards(kinds[segment.kind]) for segment in reversed(picked.outward))
    off, *rest = (segment.backwards(SegmentKind.DEPART) for segment in reversed(picked.inward))
    # Away from the item the cup need not be as slow as during contact.
    off = replace(off, limits=SegmentLimits(max_tool_speed=back.context.settings.approach_speed))
    return PlaceMotion(back.scene, inward, (off, *rest), cost)
