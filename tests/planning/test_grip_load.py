"""The load on the cup: planner and verifier derive it by different means and must agree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.tool import ToolState
from pickcli.collision.motion_segment import Mode, MotionSegment
from pickcli.geometry import inverse, pose, rotation_axis_angle
from pickcli.grasping.holding import Hold
from pickcli.grasping.suction_grasping import SuctionGrasping
from pickcli.kinematics.arm import Arm
from pickcli.motion.segment import SegmentKind, SegmentLimits
from pickcli.motion.trajectory import Trajectory
from pickcli.planning.assembly.grip_load import carried_load
from pickcli.planning.assembly.proven_timing import divided_lift
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from pickcli.verification.load_check import SAMPLE_TIME, wrenches
from support.tool_states import DOWN, STRAIGHT


@pytest.fixture(scope="module")
def arm(cell: Cell) -> Arm:
    return Arm(cell.robot)


AGREE = 2e-4  # of the largest figure: differences over 1 ms against derivatives


def random_motion(cell: Cell, rng: np.random.Generator, n: int = 6) -> Trajectory:
    """Smooth and fast, from rest to rest: speeds and accelerations up to about the joints' limits."""
    limits = cell.robot.limits
    low, high = np.maximum(limits.lower, -1.5), np.minimum(limits.upper, 1.5)
    middle, half = (low + high) / 2, 0.3 * (high - low)
    inner = rng.uniform(-1.0, 1.0, (n, cell.robot.n_joints))
    velocities = 0.5 * limits.velocity * rng.uniform(-1.0, 1.0, inner.shape)
    accelerations = 0.5 * limits.acceleration * rng.uniform(-1.0, 1.0, inner.shape)
    velocities[[0, -1]] = accelerations[[0, -1]] = 0.0
    times = 0.6 * np.arange(float(n))
    return Trajectory(cell.robot.joint_names, times, middle + half * inner, velocities, accelerations)


@pytest.mark.parametrize("seed", range(12))
def test_planner_and_verifier_agree_on_a_random_held_motion(cell: Cell, arm: Arm, seed: int) -> None:
    rng = np.random.default_rng(seed)
    item = list(cell.items.values())[int(rng.integers(len(cell.items)))]
    axis = rng.normal(size=3)
    T_tip_item = pose(
        rng.uniform(-0.08, 0.08, 3), R=rotation_axis_angle(axis / np.linalg.norm(axis), rng.uniform(0, 3))
    )
    tool_state = (STRAIGHT, DOWN)[seed % 2]
    trajectory = random_motion(cell, rng)
    face = item.shape.face_names[0]
    hold = SuctionGrasping(cell.robot.tool).hold(item, face, T_tip_item)
    times = np.arange(1.0, int(trajectory.duration / SAMPLE_TIME) - 1) * SAMPLE_TIME
    states = trajectory.sample(np.concatenate([[times[0] - SAMPLE_TIME], times, [times[-1] + SAMPLE_TIME]]))
    by_verifier = wrenches(
        tip_poses(cell.robot, link_poses(cell.robot, states), tool_state), T_tip_item, item, SAMPLE_TIME
    )
    q, dq, ddq = (trajectory.sample(times, d) for d in range(3))
    motion = arm.tip_motion(q, dq, ddq, tool_state)
    by_planner = hold.body.wrench(motion)
    # Differences that reach over a point of the trajectory, where the jerk jumps, see a little of both sides.
    smooth = np.abs(times[:, None] - trajectory.times).min(axis=1) > 1.5 * SAMPLE_TIME
    most = np.abs(by_planner).max(axis=0)
    assert most[:3].min() > 0.0
    np.testing.assert_allclose(by_verifier[smooth, :3], by_planner[smooth, :3], atol=AGREE * most[:3].max())
    np.testing.assert_allclose(by_verifier[smooth, 3:], by_planner[smooth, 3:], atol=AGREE * most[3:].max())
    load = carried_load(arm, tool_state, trajectory, hold)
    assert load.twist == pytest.approx(np.abs(by_verifier[:, 5]).max(), rel=0.02)
    assert load.moment == pytest.approx(np.hypot(*by_verifier[:, 3:5].T).max(), rel=0.02)
    if hold.share > 0.0:  # the random tip may be beside the face
        worst = float(cell.robot.tool.cup.limits.ratio(by_verifier, hold.share).max())
        assert load.ratio == pytest.approx(worst, rel=0.02)


def test_an_item_hangs_where_the_pressed_cup_left_it(cell: Cell, arm: Arm) -> None:
    """At rest with the cup straight down the lever is that of the hanging item, not that of the grasp."""
    item = cell.item("crayola_24_ct", 2016)
    grasp, pressed = pose([0.02, 0.0, 0.0125], rpy=[np.pi, 0.0, 0.0]), pose([0.0, 0.0, 0.005])
    hold = SuctionGrasping(cell.robot.tool).hold(item, "+z", inverse(grasp @ pressed))
    load = hold.at_rest(np.diag([1.0, -1.0, -1.0])[None])
    assert load.moment == pytest.approx(item.heaviest * 9.81 * 0.02)
    assert hold.body.p_tip_com[2] == pytest.approx(0.0125 - 0.005)


UPWARDS = 0.05  # m of the lift


def lift(cell: Cell, arm: Arm, tool_state: ToolState) -> MotionSegment:
    """Straight up in front of a bin."""
    start = cell.configurations["bin_H"].q
    T = arm.tips(start[None], tool_state)[0]
    poses = np.stack([pose(T[:3, 3] + [0.0, 0.0, z], R=T[:3, :3]) for z in np.linspace(0, UPWARDS, 26)[1:]])
    waypoints = np.vstack([start, arm.follow(poses, tool_state, start).configurations])
    limits = SegmentLimits(max_tool_speed=0.25)
    return MotionSegment(SegmentKind.LIFT, waypoints, limits, mode=Mode(tool_state))


def bottle_in_front(cell: Cell, mass: float) -> Hold:
    """Its own axis upright, the cup on its mantle."""
    item = replace(cell.item("dasani_water_bottle", 2016), mass=mass)
    T_tip_item = pose([0.0, 0.0, 0.0335], rpy=[0.0, np.pi / 2, 0.0])
    return SuctionGrasping(cell.robot.tool).hold(item, "mantle", T_tip_item)


def test_a_weight_that_turns_the_item_on_the_cup_is_taken_up_by_itself(cell: Cell, arm: Arm) -> None:
    tool, whole = cell.robot.tool, lift(cell, arm, STRAIGHT)
    divided = divided_lift(arm, SuctionGrasping(tool), whole, bottle_in_front(cell, 0.52))
    assert divided is not None
    slow, rest = divided
    assert slow.limits.max_tool_speed == pytest.approx(0.98 * tool.cup.take_up_speed)
    assert rest.limits == whole.limits and slow.mode == rest.mode == whole.mode
    tips = arm.tips(np.stack([slow.start, slow.end]), STRAIGHT)
    assert np.linalg.norm(tips[1, :3, 3] - tips[0, :3, 3]) == pytest.approx(tool.cup.take_up, rel=0.02)
    np.testing.assert_array_equal(slow.start, whole.start)
    np.testing.assert_array_equal(slow.end, rest.start)
    np.testing.assert_array_equal(rest.end, whole.end)


def test_what_hardly_turns_on_the_cup_or_hangs_below_it_is_lifted_at_once(cell: Cell, arm: Arm) -> None:
    method = SuctionGrasping(cell.robot.tool)
    assert divided_lift(arm, method, lift(cell, arm, STRAIGHT), bottle_in_front(cell, 0.1)) is None
    down = np.diag([1.0, -1.0, -1.0])
    beside = method.hold(cell.item("dasani_water_bottle", 2016), "mantle", pose([0.05, 0.0, 0.03]))
    assert beside.torque_at_rest(down) > 0.4
    assert divided_lift(arm, method, lift(cell, arm, DOWN), beside) is None
