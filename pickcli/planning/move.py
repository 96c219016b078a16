"""``plan_move``: a move of the empty tool (KTH's move primitive)."""

from __future__ import annotations

import time

from pickcli.collision.motion_segment import Mode
from pickcli.errors import Failures, NoPlanError
from pickcli.geometry import Array
from pickcli.kinematics.continuous_joints import ways_round
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.planning.assembly.stitching import stitch_run
from pickcli.planning.coarse_motion import plan_coarse
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.roadmap.query_experience import ExperienceRecorder
from pickcli.scene.scene import Scene
from pickcli.seeds import derived_seed


def plan_move(
    context: PlanningContext,
    scene: Scene,
    start: Start,
    q_goal: Array,
    seed: int = 0,
    label: str = "move",
    recorder: ExperienceRecorder | None = None,
) -> Plan:
    """Plan a move of the empty tool from rest to rest, in its current tool state.

    Args:
        context: The cell, its models and its precomputed files.
        scene: Poses as perceived; their noise bounds inflate the shapes.
        start: Configuration and tool state in which the robot is at rest.
        q_goal: (n,) goal configuration; continuous joints take the shorter way, up to whole turns.
        seed: Seed of all random choices.
        label: Name of the plan, also in messages.
        recorder: Records experience of coarse queries; None discards it.

    Returns:
        The plan, uncertified.

    Raises:
        NoPlanError: If the goal is not free or no motion to it was found; with the reasons.
    """
    began = time.perf_counter()
    mode = Mode(start.tool_state)
    checker = context.checker_for(scene, mode)
    query = f"{label} with the tool {start.tool_state}"
    if not checker.is_valid(q_goal):
        raise NoPlanError(query, [checker.explain(q_goal).at("goal")])
    goals = ways_round(context.arm.limits, q_goal, start.q)
    coarse = plan_coarse(
        context, checker, start.q, goals, [0.0] * len(goals), derived_seed(seed, label), "move"
    )
    if isinstance(coarse, Failures):
        raise NoPlanError(query, coarse)
    if recorder is not None:
        recorder.record(coarse.experience)
    plan = stitch_run(context, scene, [coarse.segment(SegmentKind.TRANSIT, mode)], label, seed)
    if isinstance(plan, Failures):
        raise NoPlanError(query, plan)
    return plan.with_statistics(planning_ms=1e3 * (time.perf_counter() - began))
