"""What the motors cannot do is refused, with its figures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.geometry import inverse
from pickcli.kinematics.arm import Arm
from pickcli.kinematics.arm_dynamics import ArmDynamics
from pickcli.kinematics.held_body import HeldBody
from pickcli.motion.plan import Plan
from pickcli.scene.scene import Scene
from pickcli.verification.effort_check import MOTOR_SHARE
from pickcli.verification.verify import verify
from support.handmade_plans import bound, pick


def with_motors(scene: Scene, joint: str, effort: float) -> Scene:
    robot = scene.cell.robot
    forces = {**robot.motor_forces, joint: effort}
    return replace(scene, cell=replace(scene.cell, robot=replace(robot, motor_forces=forces)))


def test_a_motor_that_is_too_weak_is_named_with_what_it_lacks() -> None:
    plan, scene = pick()
    assert verify(plan, scene).certificate is not None
    (reason,) = verify(plan, with_motors(scene, "joint_l", 200.0)).reasons
    assert reason.what == "motor too weak" and reason.where.startswith("segment ")
    assert reason.detail.startswith("joint_l: ") and reason.detail.endswith(
        "of 200 Nm; at most 92% may be used"
    )


def test_a_rail_is_judged_by_its_force() -> None:
    plan, scene = pick()
    reasons = verify(plan, with_motors(scene, "rail", 1.0)).reasons
    assert [reason.what for reason in reasons] == ["motor too weak"] and "of 1 N;" in reasons[0].detail


def test_what_is_held_counts() -> None:
    """The motor just bears the motion with the item as it is, and not with one that is a kilogram heavier."""
    plan, scene = pick()
    limit = effort(plan, scene) / MOTOR_SHARE
    assert not verify(plan, with_motors(scene, "joint_l", limit * 1.001)).reasons
    item = replace(scene.items[0].item, mass=scene.items[0].item.mass + 1.0)
    heavier = scene.moved(replace(scene.items[0], item=item))
    told = verify(bound(plan, heavier), with_motors(heavier, "joint_l", limit * 1.001)).reasons
    assert "motor too weak" in {reason.what for reason in told}


def effort(plan: Plan, scene: Scene) -> float:
    """Nm that joint_l exerts at most, as the verifier computes it."""
    reasons = verify(plan, with_motors(scene, "joint_l", 1.0)).reasons
    (told,) = (reason.detail for reason in reasons if reason.detail.startswith("joint_l: "))
    return float(told.split()[1])


def test_an_item_counts_once_where_two_segments_meet() -> None:
    """The efforts are those of the planner's inverse dynamics, at the instants between segments, too."""
    plan, scene = pick()
    item = replace(scene.items[0].item, mass=3.0)
    scene = scene.moved(replace(scene.items[0], item=item))
    plan = bound(plan, scene)
    assert plan.grasp is not None
    T_tip_item = inverse(plan.grasp.T_item_tip)
    inertia = item.inertia * (1.0 + item.mass_error)
    held = HeldBody(item.heaviest, T_tip_item[:3, 3], T_tip_item[:3, :3] @ inertia @ T_tip_item[:3, :3].T)
    arm, most = Arm(scene.cell.robot), 0.0
    for segment in plan.segments:
        during = np.linspace(segment.t_start, segment.t_end, 100)
        dynamics = ArmDynamics(arm, segment.tool_state, None if segment.held is None else held)
        efforts = np.abs(dynamics.efforts(*plan.trajectory.states(during)))[:, arm.names.index("joint_l")]
        most = max(most, float(efforts.max()))
    assert effort(plan, scene) == pytest.approx(most, rel=0.02)
