"""Transfer: the coarse motion with the item to the placement with the fastest complete motion."""

from __future__ import annotations

from collections.abc import Sequence

from pickcli.errors import Failures
from pickcli.planning.pick_motion import GraspMotion, GraspTransit, PickMotion, PlaceMotion, Transfer
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.stages.item_transfer import plan_direct_transfer, plan_transfer_with_tool_change
from pickcli.planning.stages.placement import plan_placements
from pickcli.planning.stages.shift_end import plan_end_of_shift
from pickcli.planning.stages.upright_transfer import plan_upright_transfer


def plan_transfer(problem: PickProblem, reached: GraspTransit) -> PickMotion | Failures:
    """Complete the motion for one grasp, with the best reachable placement.

    Args:
        problem: The pick.
        reached: The grasp with the transit to it.

    Returns:
        All segments of the pick, or every reason for failure.
    """
    taking, failures = reached.taking, Failures()
    if problem.shift is not None:
        end = plan_end_of_shift(problem, taking)
        return end if isinstance(end, Failures) else PickMotion(reached.transit, taking, Transfer((), end))
    for placements in plan_placements(problem, taking):
        if isinstance(placements, Failures):
            failures += placements
            continue
        limits = problem.context.arm.limits
        placements = tuple(motion.unwound_towards(limits, taking.end) for motion in placements)
        transfer = _transfer(problem, taking, placements)
        if not isinstance(transfer, Failures):
            return PickMotion(reached.transit, taking, transfer)
        failures += transfer
    return failures


def _transfer(
    problem: PickProblem, taking: GraspMotion, placements: Sequence[PlaceMotion]
) -> Transfer | Failures:
    """Find a transfer to one of several placements, which hold the item in one state of the tool."""
    upright = problem.context.settings.upright
    if placements[0].holding_state != taking.holding_state:
        return plan_transfer_with_tool_change(problem, taking, placements)
    if upright is not None:
        return plan_upright_transfer(problem, taking, placements, upright)
    return plan_direct_transfer(problem, taking, placements)
