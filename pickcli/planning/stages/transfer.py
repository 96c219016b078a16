"""Transfer: the coarse motion with the item to the placement with the fastest complete motion."""

from __future__ import annotations

from pickcli.errors import Failures
from pickcli.planning.pick_motion import GraspTransit, PickMotion, Transfer
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
        keeps_state = placements[0].holding_state == taking.holding_state
        in_one_state = plan_direct_transfer if problem.max_tilt is None else plan_upright_transfer
        plan = in_one_state if keeps_state else plan_transfer_with_tool_change
        transfer = plan(problem, taking, placements)
        if not isinstance(transfer, Failures):
            return PickMotion(reached.transit, taking, transfer)
        failures += transfer
    return failures
