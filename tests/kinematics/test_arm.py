"""The arm against an oracle in numpy, and what inverse kinematics promises."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.robot import JointType, Robot
from pickcli.cell.tool import MOVING, ToolState
from pickcli.geometry import Array, is_pose, pose, rotation_angle, rotation_axis_angle, rotation_vector
from pickcli.kinematics.arm import Arm
from pickcli.kinematics.chain import bodies_of_frames
from support.tool_states import ALL_STATES, DOWN, STRAIGHT

STATES = ALL_STATES


def oracle_tip(robot: Robot, q: Array, tool_state: ToolState) -> Array:
    """Forward kinematics straight from the URDF's definition, one joint after the other."""
    position = dict(zip(robot.joint_names, q, strict=True))
    still = STRAIGHT if tool_state == MOVING else tool_state
    assert robot.tool.joint is not None
    position[robot.tool.joint] = robot.tool.positions[still]
    T = robot.T_world_base
    for joint in robot.joints:
        value = position.get(joint.name, 0.0)
        turn = pose(joint.axis * value)
        if joint.type in (JointType.REVOLUTE, JointType.CONTINUOUS):
            turn = pose(R=rotation_axis_angle(joint.axis, value))
        T = T @ joint.T_parent_joint @ turn
    return np.asarray(T @ robot.tool.T_last_tip)


@pytest.mark.parametrize("tool_state", STATES)
def test_tip_agrees_with_the_oracle(arm: Arm, tool_state: ToolState, rng: np.random.Generator) -> None:
    Q = arm.random_seeds(rng, 50)
    expected = np.array([oracle_tip(arm.robot, q, tool_state) for q in Q])
    np.testing.assert_allclose(arm.tips(Q, tool_state), expected, atol=1e-12)
    np.testing.assert_allclose(arm.tip(Q[0], tool_state), expected[0], atol=1e-12)


def test_home_stands_where_it_was_measured(cell: Cell, arm: Arm) -> None:
    tip = arm.tip(cell.configurations["home"].q, STRAIGHT)
    np.testing.assert_allclose(tip[:3, 3], [-0.605, 0.0, 1.716], atol=1e-3)
    np.testing.assert_allclose(tip[:3, 2], [1, 0, 0], atol=0.05)  # the lance is level, pointing at the shelf


def test_cup_down_points_down_in_front_of_the_shelf(cell: Cell, arm: Arm) -> None:
    tip = arm.tip(cell.configurations["home"].q, DOWN)
    np.testing.assert_allclose(tip[:3, 2], [0, 0, -1], atol=0.05)


def test_a_configuration_is_moved_along_the_rail_alone_over_all_of_its_range(cell: Cell, arm: Arm) -> None:
    q = cell.configurations["home"].q
    moved = arm.along_rails(q, 4)
    rail = arm.names.index("rail")
    low, high = arm.limits.lower[rail], arm.limits.upper[rail]
    np.testing.assert_allclose((moved[:, rail] - low) / (high - low), [0.125, 0.375, 0.625, 0.875])
    assert (np.delete(moved, rail, axis=1) == np.delete(q, rail)).all()


@pytest.mark.parametrize("tool_state", [STRAIGHT, DOWN])
def test_jacobian_is_the_derivative(arm: Arm, tool_state: ToolState, rng: np.random.Generator) -> None:
    for q in arm.random_seeds(rng, 10):
        J, T = arm.jacobian(q, tool_state), arm.tip(q, tool_state)
        for j in range(arm.n):
            step = np.zeros(arm.n)
            step[j] = 1e-6
            ahead = arm.tip(q + step, tool_state)
            np.testing.assert_allclose(J[:3, j], (ahead[:3, 3] - T[:3, 3]) / 1e-6, atol=1e-5)
            np.testing.assert_allclose(
                J[3:, j], rotation_vector(ahead[:3, :3] @ T[:3, :3].T) / 1e-6, atol=1e-4
            )


@pytest.mark.parametrize("tool_state", [STRAIGHT, DOWN])
def test_reachable_poses_are_reached(arm: Arm, tool_state: ToolState, rng: np.random.Generator) -> None:
    n_solved = 0
    for q in arm.random_seeds(rng, 60):
        target = arm.tip(q, tool_state)
        solutions = arm.solve_spread(target, tool_state, rng, 24)
        n_solved += len(solutions) > 0
        for solution in solutions:
            off = np.linalg.inv(target) @ arm.tip(solution, tool_state)
            assert np.linalg.norm(off[:3, 3]) <= 2e-5 and rotation_angle(off[:3, :3]) <= 2e-4
            assert np.all(solution >= arm.limits.lower) and np.all(solution <= arm.limits.upper)
    assert n_solved >= 59


def test_solutions_are_distinct_and_spread_over_the_rail(arm: Arm, rng: np.random.Generator) -> None:
    target = arm.tip(np.array([0.5, 0.2, 0.5, 0.0, -1.2, 0.0, 0.3, 0.0]), STRAIGHT)
    solutions = arm.solve_spread(target, STRAIGHT, rng, 32)
    gaps = np.abs(solutions[:, None] - solutions[None]).max(axis=2)[np.triu_indices(len(solutions), 1)]
    assert gaps.min() > 0.04
    assert np.ptp(solutions[:, 0]) > 0.25


def test_same_seed_same_solutions(arm: Arm) -> None:
    target = arm.tip(np.full(arm.n, 0.4), STRAIGHT)
    a, b = (arm.solve_spread(target, STRAIGHT, np.random.default_rng(3)) for _ in range(2))
    np.testing.assert_array_equal(a, b)


def test_unreachable_is_an_empty_answer(arm: Arm, rng: np.random.Generator) -> None:
    far = pose((5.0, 0, 1))
    assert arm.solve(far, STRAIGHT, arm.random_seeds(rng, 5)).shape == (0, arm.n)


def test_manipulability_vanishes_where_the_arm_is_stretched(arm: Arm, rng: np.random.Generator) -> None:
    stretched = np.zeros(arm.n)
    stretched[0] = 0.5
    assert arm.manipulability(stretched, STRAIGHT) < 1e-6
    bent = np.array([0.5, 0.2, 0.5, 0.3, -1.2, 0.4, 0.3, 0.0])
    J = arm.jacobian(bent, STRAIGHT)
    singular_values = np.linalg.svd(np.diag([1, 1, 1, 0.5, 0.5, 0.5]) @ J, compute_uv=False)
    assert arm.manipulability(bent, STRAIGHT) == pytest.approx(np.prod(singular_values), rel=1e-9)


def test_tips_are_poses_in_every_tool_state(arm: Arm, rng: np.random.Generator) -> None:
    q = arm.random_seeds(rng, 1)[0]
    assert all(is_pose(arm.tip(q, tool_state)) for tool_state in STATES)
    np.testing.assert_array_equal(arm.tip(q, MOVING), arm.tip(q, STRAIGHT))


def test_bodies_group_what_fixed_joints_join(arm: Arm) -> None:
    bodies = dict(zip([j.child for j in arm.robot.joints], bodies_of_frames(arm.robot), strict=True))
    assert bodies["carriage"] == bodies["arm_base"] == 1
    assert bodies["link_t"] == bodies["lance"] == bodies["cup"] == 8


def test_joints_that_turn_twice_stay_in_the_turn_that_is_asked_for() -> None:
    """Two turns of a UR5e's joints are 64 names of one posture, and ways between them are long."""
    arm = Arm(load_cell("ur5e_crates").robot)
    state, rng = arm.robot.tool.default_state, np.random.default_rng(1)
    lower, upper = arm.limits.window
    assert ((upper - lower) > 3.5 * np.pi).sum() >= 4
    for q in arm.random_seeds(rng, 20):
        assert np.abs(q).max() <= np.pi
        T = arm.tip(q, state)
        near, there = arm.solve_spread(T, state, rng), arm.solve(T, state, q)
        assert len(near) > 0 and np.abs(near).max() <= np.pi
        assert len(there) > 0 and np.abs(there - q).max() <= np.pi
        for found in (*near, *there):
            assert np.allclose(arm.tip(found, state), T, atol=1e-4)


def test_a_descent_keeps_fixed_joints_and_ends_in_the_same_wherever_it_began(
    arm: Arm, rng: np.random.Generator
) -> None:
    fixed, n_found = (0, 3), 0
    for q in arm.random_seeds(rng, 30):
        T = arm.tip(q, STRAIGHT)
        near = [
            q + np.where(np.isin(np.arange(arm.n), fixed), 0.0, rng.uniform(-0.05, 0.05, arm.n)) for _ in "ab"
        ]
        found = [arm.solve_near(T, STRAIGHT, start, fixed) for start in near]
        for solved in filter(lambda each: each is not None, found):
            assert solved is not None
            assert np.array_equal(solved[list(fixed)], q[list(fixed)])
            np.testing.assert_allclose(arm.tip(solved, STRAIGHT), T, atol=1e-8)
        first, second = found
        if first is not None and second is not None and np.abs(first - second).max() < 0.02:
            np.testing.assert_allclose(first, second, atol=1e-6)
            n_found += 1
    assert n_found > 15


def test_a_descent_to_what_is_out_of_reach_ends_in_nothing(arm: Arm, rng: np.random.Generator) -> None:
    assert arm.solve_near(pose((9.0, 0.0, 0.0)), STRAIGHT, arm.random_seeds(rng, 1)[0]) is None
