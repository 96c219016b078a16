"""Transfer: the coarse motion with the item to the placement that makes the whole motion fastest."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pickcli.collision.motion_segment import Mode, MotionSegment
from pickcli.errors import Failures
from pickcli.motion.segment import SegmentKind
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.planning_context import RESERVE
from pickcli.planning.stages.grasp_motion import GraspMotion
from pickcli.planning.stages.grasp_transit import GraspTransit
from pickcli.planning.stages.placement import PlaceMotion, plan_placement
from pickcli.planning.stages.transit import plan_coarse
from pickcli.roadmap.query_experience import QueryExperience
from pickcli.seeds import derived_seed


@dataclass(frozen=True, eq=False)
class PickMotion:
    """The geometry of a whole pick.

    Attributes:
        transit: From where the robot is to the pre-approach.
        in_bin: In the bin, to the item and out with it.
        transfer: From the end of the retreat to where the placement begins.
        placement: To the release, and away from there.
        experience: What the search for the transfer found that was not stored.
    """

    transit: MotionSegment
    in_bin: GraspMotion
    transfer: MotionSegment
    placement: PlaceMotion
    experience: tuple[QueryExperience, ...] = ()


def plan_transfer(problem: PickProblem, reached: GraspTransit) -> PickMotion | Failures:
    """Complete the motion for one grasp, with the best placement that can be reached.

    Args:
        problem: The pick.
        reached: The grasp with the transit to it.

    Returns:
        The geometry of the whole pick, or every reason why there is none.
    """
    context, in_bin = problem.context, reached.in_bin
    placements = plan_placement(problem, in_bin)
    if isinstance(placements, Failures):
        return placements
    contacts = problem.contacts.while_transferring()
    mode = Mode(in_bin.grasp.tool_state, in_bin.attached, contacts, RESERVE)
    goals = np.stack([placement.start for placement in placements])
    extra = [placement.cost for placement in placements]
    seed = derived_seed(problem.seed, "transfer", problem.target.id)
    checker = context.checker_for(problem.scene, mode)
    coarse = plan_coarse(context, checker, in_bin.end, goals, extra, seed, "transfer")
    if isinstance(coarse, Failures):
        return coarse
    transfer = coarse.segment(SegmentKind.TRANSFER, replace(mode, reserve=0.0))
    return PickMotion(reached.transit, in_bin, transfer, placements[coarse.goal], coarse.experience)
