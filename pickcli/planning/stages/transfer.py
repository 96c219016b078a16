"""Transfer: the coarse motion with the item to the placement with the fastest complete motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.collision.motion_segment import Mode
from pickcli.errors import Failures
from pickcli.motion.segment import SegmentKind
from pickcli.planning.coarse_motion import plan_coarse
from pickcli.planning.pick_motion import GraspTransit, PickMotion
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.planning_context import COARSE_RESERVE
from pickcli.planning.stages.placement import plan_placement
from pickcli.seeds import derived_seed


def plan_transfer(problem: PickProblem, reached: GraspTransit) -> PickMotion | Failures:
    """Complete the motion for one grasp, with the best reachable placement.

    Args:
        problem: The pick.
        reached: The grasp with the transit to it.

    Returns:
        All segments of the pick, or every reason for failure.
    """
    context, taking = problem.context, reached.taking
    placements = plan_placement(problem, taking)
    if isinstance(placements, Failures):
        return placements
    limits = context.arm.limits
    placements = tuple(motion.turned_towards(limits, taking.end) for motion in placements)
    contacts = problem.contacts.while_transferring()
    mode = Mode(taking.holding_state, taking.attached, contacts, COARSE_RESERVE)
    goals = np.stack([placement.start for placement in placements])
    extra = [placement.cost for placement in placements]
    seed = derived_seed(problem.seed, "transfer", problem.target.id)
    checker = context.checker_for(problem.scene, mode)
    coarse = plan_coarse(context, checker, taking.end, goals, extra, seed, "transfer")
    if isinstance(coarse, Failures):
        return coarse
    transfer = coarse.segment(SegmentKind.TRANSFER, replace(mode, reserve=0.0))
    return PickMotion(reached.transit, taking, transfer, placements[coarse.goal], coarse.experience)
