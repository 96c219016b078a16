"""Transit: the coarse motion of the empty tool to one of several grasps, the fastest whole way first.

One that a controller rolls out leads to the nearest grasp that it reaches.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from pickcli.cell.tool import MOVING, ToolState
from pickcli.collision.motion_segment import Mode, MotionSegment
from pickcli.errors import Failures, Reason
from pickcli.motion.segment import SegmentKind
from pickcli.path_planning.path_cost import estimated_duration
from pickcli.planning.coarse_motion import plan_coarse, plan_on_hand_lattice
from pickcli.planning.coarse_path import CoarsePath
from pickcli.planning.pick_motion import GraspMotion, GraspTransit
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.pick_settings import GraspApproach
from pickcli.planning.planning_context import COARSE_RESERVE
from pickcli.planning.stages.reactive_transit import roll_out_to
from pickcli.planning.start_state import Start
from pickcli.roadmap.query_experience import QueryExperience
from pickcli.seeds import derived_seed

SCORE_COST = 0.2  # s of cost per unit of a grasp's score


def transits_to_grasps(
    problem: PickProblem, grasps: Sequence[GraspMotion], start: Start
) -> Iterator[GraspTransit | Failures]:
    """Order grasps by the fastest whole way in, each with the transit to it.

    All grasps with one tool state are planned as one goal set. The others remain as fallbacks, planned on
    demand.

    Args:
        problem: The pick.
        grasps: Feasible motions in the bin.
        start: Configuration and tool state in which the robot is at rest.

    Yields:
        A grasp with its transit, or why the grasps of one tool state are not reached.
    """
    robot = problem.context.cell.robot
    grasps = [motion.unwound_towards(robot.limits, start.q) for motion in grasps]
    states = robot.tool.states
    groups = {state: [f for f in grasps if f.grasp.tool_state == state] for state in states}
    heads: dict[ToolState, GraspTransit] = {}
    experience: tuple[QueryExperience, ...] = ()
    stuck: dict[ToolState, dict[bytes, Reason]] = {state: {} for state in groups}
    todo = list(groups)
    while todo or heads:
        for state in filter(groups.__getitem__, todo):
            head = _reached(problem, groups[state], start, stuck[state])
            if isinstance(head, Failures):
                yield head
            else:
                heads[state] = head
                experience += head.experience
        if not heads:
            return
        best = min(heads, key=lambda state: (heads[state].cost, state))
        chosen = heads.pop(best)
        yield replace(chosen, experience=experience)
        experience = ()
        groups[best].remove(chosen.taking)
        todo = [best]


def _reached(
    problem: PickProblem, group: Sequence[GraspMotion], start: Start, stuck: dict[bytes, Reason]
) -> GraspTransit | Failures:
    """Plan the fastest way to one of several grasps with one tool state, past roll-outs that got stuck."""
    context, state = problem.context, group[0].grasp.tool_state
    # While the tool changes its state on the way, its whole swept volume must be free.
    mode = Mode(state if state == start.tool_state else MOVING, reserve=COARSE_RESERVE)
    if not context.checker_for(problem.scene, mode).is_valid(start.q):
        mode = replace(mode, reserve=0.0)  # a move may end nearer to something than coarse motions pass
    goals = np.stack([f.start for f in group])
    extra = [_cost(problem, f) for f in group]
    seed = derived_seed(problem.seed, "transit", problem.target.id, state)
    checker = context.checker_for(problem.scene, mode)
    rolled = None
    if context.settings.approach is GraspApproach.REACTIVE:
        rolled = roll_out_to(context, checker, start.q, goals, state, seed, stuck)
    coarse: CoarsePath | Failures
    if isinstance(rolled, CoarsePath):
        coarse = rolled
    elif (most := context.settings.expansions) is not None:
        coarse = plan_on_hand_lattice(context, checker, start.q, goals, most, "transit")
    else:
        coarse = plan_coarse(context, checker, start.q, goals, extra, seed, "transit")
    if isinstance(coarse, Failures):
        return rolled + coarse if isinstance(rolled, Failures) else coarse
    transit = coarse.segment(SegmentKind.TRANSIT, replace(mode, reserve=0.0))
    cost = coarse.duration + extra[coarse.goal]
    is_rolled_out = None if rolled is None else coarse is rolled
    return GraspTransit(group[coarse.goal], transit, cost, coarse.experience, coarse.searched, is_rolled_out)


def _cost(problem: PickProblem, f: GraspMotion) -> float:
    """Estimate the seconds from the pre-approach to the end of the retreat, plus the grasp's penalties."""
    worth = problem.context.settings.load_worth
    duration = sum(_duration(problem, segment) for segment in (*f.inward, *f.outward))
    return duration + SCORE_COST * f.grasp.score + worth * f.grasp.load_ratio


def _duration(problem: PickProblem, segment: MotionSegment) -> float:
    """Estimate the seconds of a straight line, by the joints and by the limit of the tool's speed."""
    context, limit = problem.context, segment.limits.max_tool_speed
    by_joints = estimated_duration(context.space, segment.waypoints)
    if limit is None:
        return by_joints
    ends = context.arm.tips(segment.waypoints[[0, -1]], segment.mode.tool_state)
    return max(by_joints, float(np.linalg.norm(ends[1, :3, 3] - ends[0, :3, 3])) / limit)
