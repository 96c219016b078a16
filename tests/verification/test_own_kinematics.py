"""The verifier's own forward kinematics, against figures worked out by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from pickcli.cell.robot import JointType
from pickcli.geometry import inverse, pose
from pickcli.verification.forward_kinematics import link_poses, reaches
from support.handmade_plans import cell, tip
from support.tool_states import DOWN, STRAIGHT


def test_home_stands_where_the_sheet_says() -> None:
    T = tip(cell().configurations["home"].q)
    assert T[:3, 3] == pytest.approx((-0.605, 0.0, 1.716), abs=1e-3)
    # the lance is level and points at the shelf
    assert T[:3, 2] == pytest.approx((1.0, 0.0, 0.0), abs=0.35)


def test_the_stretched_arm_is_a_sum_of_lengths() -> None:
    """All joints at zero: the arm stands upright, 0.85 + 0.41 + 0.49 + 0.42 + 0.18 m, then the tool."""
    q = np.zeros(8)
    q[0] = 0.4
    assert tip(q)[:3, 3] == pytest.approx((-1.758 + 0.4, 0.0, 2.35 + 0.54), abs=1e-9)
    # turned down: the cup's last 30 mm point along the flange's +x
    assert tip(q, DOWN)[:3, 3] == pytest.approx((-1.358 + 0.03, 0.0, 2.35 + 0.51), abs=1e-9)
    assert tip(q, DOWN)[:3, 2] == pytest.approx((1.0, 0.0, 0.0), abs=1e-9)


def test_one_joint_at_a_time() -> None:
    q = np.zeros(8)
    q[2] = np.pi / 2  # l about +y lays the arm forward, from z = 1.26
    assert tip(q, STRAIGHT)[:3, 3] == pytest.approx((-1.758 + 0.49 + 0.42 + 0.18 + 0.54, 0.0, 1.26), abs=1e-9)
    q[1] = np.pi / 2  # then s about +z turns it to the left
    assert tip(q)[:3, 3] == pytest.approx((-1.758, 1.63, 1.26), abs=1e-9)
    q[4] = np.pi / 2  # and u about -y bends the forearm, 0.60 m and the tool, back up
    assert tip(q)[:3, 3] == pytest.approx((-1.758, 0.49, 1.26 + 1.14), abs=1e-9)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_no_point_moves_farther_than_its_reach_allows(seed: int) -> None:
    """The bound that the clearance proof stands on: |move| <= sum of reach times |joint move|."""
    rng = np.random.default_rng(seed)
    robot = cell().robot
    lower, upper = robot.limits.lower, robot.limits.upper
    Q = rng.uniform(lower, upper, size=(2, 8))
    Q[1] = Q[0] + (Q[1] - Q[0]) * rng.choice([1e-4, 1e-2, 1.0])
    poses = link_poses(robot, Q)
    for link in range(len(robot.links) - 1):
        point = rng.normal(size=3)
        point *= rng.uniform(0, 0.4) / np.linalg.norm(point)
        a, b = (T[:3, :3] @ point + T[:3, 3] for T in poses[link])
        allowed = reaches(robot, link, float(np.linalg.norm(point))) @ np.abs(Q[1] - Q[0])
        assert np.linalg.norm(b - a) <= allowed + 1e-9


@given(
    st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda v: float(np.linalg.norm(v)) > 0.1),
    st.floats(-7.0, 7.0),
    st.tuples(*[st.floats(-3.0, 3.0)] * 3),
)
@settings(max_examples=40, deadline=None, derandomize=True)
def test_a_joint_turns_about_its_axis_wherever_that_points(
    axis: tuple[float, float, float], q: float, rpy: tuple[float, float, float]
) -> None:
    """Against scipy's rotations: the first joint that turns, with another axis."""
    robot = cell().robot
    k = next(k for k, joint in enumerate(robot.joints) if joint.type is JointType.REVOLUTE)
    unit, T = np.array(axis) / np.linalg.norm(axis), pose((0.1, -0.2, 0.3), rpy=rpy)
    joints = (
        *robot.joints[:k],
        replace(robot.joints[k], axis=unit, T_parent_joint=T),
        *robot.joints[k + 1 :],
    )
    turned = np.zeros((1, 8))
    turned[0, robot.joint_names.index(robot.joints[k].name)] = q
    links = link_poses(replace(robot, joints=joints), turned)
    parent, child = (
        next(i for i, link in enumerate(robot.links) if link.name == name)
        for name in (robot.joints[k].parent, robot.joints[k].child)
    )
    found = inverse(links[parent, 0] @ T) @ links[child, 0]
    np.testing.assert_allclose(found[:3, :3], Rotation.from_rotvec(q * unit).as_matrix(), atol=1e-12)
    np.testing.assert_allclose(found[:3, 3], 0.0, atol=1e-12)
