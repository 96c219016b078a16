"""A cell's limit of the tool's speed holds in every planned motion, and the verifier sees to it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.fingerprint import fingerprint
from pickcli.cell.tool import ToolState
from pickcli.motion.plan import Plan
from pickcli.planning.move import MoveGoal, plan_move
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.recovery.retrace import StoppedMotion, back_to_start
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.scene.scene_file import scene_hash
from pickcli.verification.verify import verify
from support.tool_states import DOWN, STRAIGHT

LIMIT = 0.3  # m/s


def limited(cell: Cell, speed: float) -> Cell:
    slow = replace(cell, max_tool_speed=speed)
    return replace(slow, fingerprint=fingerprint(slow))


def moved(context: PlanningContext, tool_state: ToolState = STRAIGHT) -> tuple[Plan, Scene]:
    cell = context.cell
    scene = Scene(cell, cell.T_world_pod, (), PoseNoise())
    start = Start(cell.configurations["home"].q, tool_state)
    return plan_move(context, scene, start, MoveGoal(cell.configurations["midway"].q)), scene


def fastest(context: PlanningContext, plan: Plan, tool_state: ToolState) -> float:
    """By the Jacobian at every half millisecond, unlike planner and verifier."""
    t = np.arange(0.0, plan.trajectory.duration, 5e-4)
    states = zip(plan.trajectory.sample(t), plan.trajectory.sample(t, 1), strict=True)
    return max(float(np.linalg.norm(context.arm.jacobian(q, tool_state)[:3] @ dq)) for q, dq in states)


@pytest.mark.parametrize("tool_state", [STRAIGHT, DOWN])
def test_no_motion_is_faster_and_the_limit_is_used(cell: Cell, tool_state: ToolState) -> None:
    context = PlanningContext(limited(cell, LIMIT))
    plan, scene = moved(context, tool_state)
    speeds = [fastest(context, plan, place) for place in (STRAIGHT, DOWN)]
    assert 0.9 * LIMIT < max(speeds) <= LIMIT
    verdict = verify(plan, scene)
    assert verdict.certificate is not None, verdict.reasons


def test_the_lower_the_limit_the_longer_the_motion(cell: Cell) -> None:
    durations = [
        moved(PlanningContext(limited(cell, speed)))[0].trajectory.duration for speed in (0.1, 0.3, 0.9)
    ]
    assert durations[0] > 2.0 * durations[1] > 2.0 * durations[2]


def test_the_way_back_after_a_stop_keeps_the_limit_too(cell: Cell) -> None:
    context = PlanningContext(limited(cell, LIMIT))
    plan, scene = moved(context)
    stopped = StoppedMotion(plan, 0.8 * plan.trajectory.duration)
    back = back_to_start(stopped, stopped.plan.segments[0].tool_state, scene, context.arm.limits, 0)
    assert isinstance(back, Plan)
    assert fastest(context, back, STRAIGHT) <= LIMIT
    verdict = verify(back, scene)
    assert verdict.certificate is not None, verdict.reasons


def test_the_verifier_refuses_what_is_faster(cell: Cell, context: PlanningContext) -> None:
    free, _ = moved(context)
    most = max(fastest(context, free, place) for place in (STRAIGHT, DOWN))
    for limit, is_accepted in ((1.01 * most, True), (0.99 * most, False)):
        slow = limited(cell, limit)
        scene = Scene(slow, slow.T_world_pod, (), PoseNoise())
        bound = replace(free, cell_fingerprint=slow.fingerprint, scene_hash=scene_hash(scene))
        verdict = verify(bound, scene)
        assert (verdict.certificate is not None) is is_accepted
        assert is_accepted or [reason.what for reason in verdict.reasons] == ["tool speed"]
