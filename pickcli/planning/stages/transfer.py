"""Transfer: the coarse motion with the item to the placement with the fastest complete motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pickcli.collision.motion_segment import Mode
from pickcli.errors import Failures
from pickcli.motion.segment import SegmentKind
from pickcli.planning.coarse_motion import plan_coarse
from pickcli.planning.pick_motion import GraspMotion, GraspTransit, PickMotion, PlaceMotion, Transfer
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.planning_context import COARSE_RESERVE
from pickcli.planning.stages.placement import placing_states, plan_placement
from pickcli.planning.stages.turned_transfer import plan_turned_transfer
from pickcli.seeds import derived_seed


def plan_transfer(problem: PickProblem, reached: GraspTransit) -> PickMotion | Failures:
    """Complete the motion for one grasp, with the best reachable placement.

    Args:
        problem: The pick.
        reached: The grasp with the transit to it.

    Returns:
        All segments of the pick, or every reason for failure.
    """
    taking, failures = reached.taking, Failures()
    for tool_state in placing_states(problem, taking):
        placements = plan_placement(problem, taking, tool_state)
        if isinstance(placements, Failures):
            failures += placements
            continue
        limits = problem.context.arm.limits
        placements = tuple(motion.turned_towards(limits, taking.end) for motion in placements)
        plan = _direct if tool_state == taking.grasp.tool_state else plan_turned_transfer
        transfer = plan(problem, taking, placements)
        if not isinstance(transfer, Failures):
            return PickMotion(reached.transit, taking, transfer)
        failures += transfer
    return failures


def _direct(
    problem: PickProblem, taking: GraspMotion, placements: Sequence[PlaceMotion]
) -> Transfer | Failures:
    """Find the transfer to the placement with the fastest complete motion, in one state of the tool."""
    mode = Mode(taking.holding_state, taking.attached, problem.contacts.while_transferring(), COARSE_RESERVE)
    goals = np.stack([placement.start for placement in placements])
    extra = [placement.cost for placement in placements]
    seed = derived_seed(problem.seed, "transfer", problem.target.id)
    checker = problem.context.checker_for(problem.scene, mode)
    coarse = plan_coarse(problem.context, checker, taking.end, goals, extra, seed, "transfer")
    if isinstance(coarse, Failures):
        return coarse
    segment = coarse.segment(SegmentKind.TRANSFER, replace(mode, reserve=0.0))
    return Transfer((segment,), placements[coarse.goal], coarse.experience)
