"""What is seen from a running belt, by first principles; and a plan made with a wrong sign is rejected."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.robots.travelling import travelling
from pickcli.geometry import Array, inverse, pose
from pickcli.motion.plan import LineTracking, Plan, times_at_work
from pickcli.motion.segment import SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.scene.item_stream import after_travel
from pickcli.verification.belt_frame import BeltFrame, farthest_brought, working_times
from pickcli.verification.belt_view import BeltView
from pickcli.verification.forward_kinematics import link_poses
from pickcli.verification.verify import verify
from support.belt_picks import BeltPick, belt_pick


def t_contact(plan: Plan) -> float:
    return next(s.t_end for s in plan.segments if s.kind is SegmentKind.CONTACT)


def ahead(pick: BeltPick, t: float) -> Array:
    """(4, 4) motion since the contact of what rides on the belt."""
    assert pick.plan.tracking is not None
    along = pick.scene.pose_of(pick.scene.cell.carriers["belt"]).T_world_carrier[:3, 0]
    return pose(tuple(pick.plan.tracking.speed * (t - t_contact(pick.plan)) * along))


def test_every_link_keeps_its_pose_relative_to_what_rides_on_the_belt() -> None:
    """Held still, the belt sees the arm where it is in the hall relative to what rides on."""
    pick = belt_pick()
    view = BeltView.of(pick.plan, pick.scene)
    hall, seen = pick.scene.cell.robot, view.seen_scene.cell.robot
    t = np.linspace(0.0, pick.plan.trajectory.duration, 23)
    in_hall = link_poses(hall, pick.plan.trajectory.sample(t))
    from_belt = link_poses(seen, view.seen.trajectory.sample(t))[-len(in_hall) :]
    for k, time in enumerate(t):
        np.testing.assert_allclose(from_belt[:, k], inverse(ahead(pick, time)) @ in_hall[:, k], atol=1e-9)


def test_what_rides_on_the_belt_has_come_along_and_nothing_else_has() -> None:
    pick = belt_pick()
    belt = BeltFrame.of(pick.plan.tracking, pick.scene)  # type: ignore[arg-type]
    later = belt.scene_at(pick.scene, 2.0)
    for before, after in zip(pick.scene.items, later.items, strict=True):
        moved = after.T_world_item[:3, 3] - before.T_world_item[:3, 3]
        expected = 0.66 * belt.T_world_start[:3, 0] if before.location == "belt" else np.zeros(3)
        np.testing.assert_allclose(moved, expected, atol=1e-12)
        assert after.noise == before.noise


def test_off_the_belt_the_plan_is_seen_from_the_hall() -> None:
    pick = belt_pick()
    _, t_left = working_times(pick.plan.segments)
    at = BeltView.of(pick.plan, pick.scene).at_work.trajectory
    off = at.times > t_left + 1e-3
    assert off.any() and not at.positions[off, 0].any() and not at.velocities[off, 0].any()
    assert (at.velocities[~off, 0] == -0.33).all()


def test_planner_and_verifier_agree_on_what_they_state_apart() -> None:
    """Each has its own words for these laws; said differently, they come to the same."""
    pick = belt_pick()
    plan, scene = pick.plan, pick.scene
    assert plan.tracking is not None
    belt, t = BeltFrame.of(plan.tracking, scene), t_contact(plan)
    ridden = belt.scene_at(scene, t).items, after_travel(scene, "belt", 0.33 * t).items
    for one, other in zip(*ridden, strict=True):
        np.testing.assert_allclose(one.T_world_item, other.T_world_item, atol=1e-12)
    robot, q = scene.cell.robot, np.column_stack([[-0.4, 0.0, 0.7], plan.trajectory.positions[:3]])
    seen = (belt.seen_robot(robot, t), travelling(robot, belt.T_world_start[:3, 0], "belt"))
    ours, theirs = (link_poses(each, q)[-len(robot.links) :] for each in seen)
    np.testing.assert_allclose(ours, theirs, atol=1e-9)
    assert working_times(plan.segments) == times_at_work(plan.segments)
    duration, t_left = plan.trajectory.duration, times_at_work(plan.segments)[1]
    assert farthest_brought(plan.tracking, t_left, duration, 0.5) == pytest.approx(
        plan.tracking.brought_by(duration, t_left, 0.5)
    )


def test_the_belt_brings_most_at_its_greatest_speed_once_the_tool_has_left_it() -> None:
    assert farthest_brought(LineTracking("belt", 0.2, 0.0, 0.03), 2.0, 5.0, 0.5) == pytest.approx(
        0.2 * 2.0 + 0.03 + 0.5 * 3.0
    )


def against(plan: Plan) -> Plan:
    """The plan of one who has the belt run backwards: at the contact in the right place, and away from it."""
    t, (t_works, t_left) = plan.trajectory.times, times_at_work(plan.segments)
    off = np.clip(t, t_works, t_left) - t_contact(plan)
    runs = (t >= t_works) & (t <= t_left)
    at = plan.trajectory
    positions, velocities = at.positions.copy(), at.velocities.copy()
    positions[:, 0] -= 2.0 * 0.33 * off
    velocities[runs, 0] -= 2.0 * 0.33
    return replace(plan, trajectory=Trajectory(at.joint_names, t, positions, velocities, at.accelerations))


def test_a_plan_that_follows_the_belt_the_wrong_way_is_rejected() -> None:
    """It also changes its speed at once; what counts is that the tool is seen to leave the item."""
    pick = belt_pick()
    assert abs(pick.plan.trajectory.sample(t_contact(pick.plan), 1)[0][0]) == pytest.approx(0.33)
    told = "\n".join(map(str, verify(against(pick.plan), pick.scene).reasons))
    assert "no time to seal" in told


def test_a_belt_that_runs_the_other_way_is_not_that_of_the_plan() -> None:
    """Items and arm are where they were; only +x of the conveyor points against the motion of the axis."""
    pick = belt_pick()
    assert pick.plan.tracking is not None
    belt = BeltFrame.of(pick.plan.tracking, pick.scene)
    turned = replace(belt, T_world_start=belt.T_world_start @ np.diag([-1.0, -1.0, 1.0, 1.0]))
    t, at = np.array([1.0]), pick.plan.trajectory
    right = belt.seen_plan(pick.plan, 0.0, at.duration).trajectory.sample(t)
    ours, wrong = (
        link_poses(each.seen_robot(pick.scene.cell.robot, 0.0), right)[-1, 0] for each in (belt, turned)
    )
    shift = ours[:3, 3] - wrong[:3, 3]
    np.testing.assert_allclose(shift, -2.0 * 0.33 * belt.T_world_start[:3, 0], atol=1e-9)
