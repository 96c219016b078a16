"""The motion of the tool frame against differences, and the wrench on a held body against momentum."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.tool import ToolState
from pickcli.geometry import GRAVITY, Array, rotation_axis_angle
from pickcli.kinematics.arm import Arm
from pickcli.kinematics.held_body import HeldBody
from pickcli.kinematics.tip_motion import TipMotion
from support.tool_states import ALL_STATES, DOWN, STRAIGHT

Motion = Callable[[float, ToolState], TipMotion]

STEP = 1e-4  # s of the central differences
UP = np.array([0.0, 0.0, 1.0])
BODY = HeldBody(
    0.7, np.array([0.02, -0.03, 0.05]), np.array([[1.1, 0.1, 0.2], [0.1, 2.0, 0.3], [0.2, 0.3, 3.0]]) * 1e-3
)


@pytest.fixture
def moving(arm: Arm, rng: np.random.Generator) -> Motion:
    """Every joint on a curve of its own."""
    q0, (swing, push) = arm.random_seeds(rng, 1)[0], rng.normal(size=(2, arm.n))

    def at(t: float, tool_state: ToolState) -> TipMotion:
        q = q0 + swing * np.sin(t) + push * t * t
        first, second = swing * np.cos(t) + 2.0 * push * t, -swing * np.sin(t) + 2.0 * push
        return arm.tip_motion(q[None], first[None], second[None], tool_state)

    return at


def difference(function: Callable[[float], Array], t: float) -> Array:
    return (function(t + STEP) - function(t - STEP)) / (2.0 * STEP)


@pytest.mark.parametrize("tool_state", ALL_STATES)
def test_tip_motion_is_the_derivative_of_the_poses(moving: Motion, tool_state: ToolState) -> None:
    for t in (-0.4, 0.0, 0.3):
        now = moving(t, tool_state)
        R = now.poses[0, :3, :3]
        spin = difference(lambda t: moving(t, tool_state).poses[0, :3, :3], t) @ R.T
        linear = difference(lambda t: moving(t, tool_state).poses[0, :3, 3], t)
        np.testing.assert_allclose(now.velocity[0], linear, atol=1e-6)
        np.testing.assert_allclose(now.angular_velocity[0], [spin[2, 1], spin[0, 2], spin[1, 0]], atol=1e-6)


@pytest.mark.parametrize("tool_state", ALL_STATES)
def test_tip_motion_accelerates_as_its_velocity_changes(moving: Motion, tool_state: ToolState) -> None:
    for t in (-0.4, 0.0, 0.3):
        now = moving(t, tool_state)
        linear = difference(lambda t: moving(t, tool_state).velocity[0], t)
        angular = difference(lambda t: moving(t, tool_state).angular_velocity[0], t)
        np.testing.assert_allclose(now.acceleration[0], linear, atol=1e-6)
        np.testing.assert_allclose(now.angular_acceleration[0], angular, atol=1e-6)


def test_tip_motion_agrees_with_the_jacobian(arm: Arm, rng: np.random.Generator) -> None:
    Q, rates = arm.random_seeds(rng, 20), rng.normal(size=(20, arm.n))
    motion = arm.tip_motion(Q, rates, np.zeros_like(Q), DOWN)
    twists = np.array([arm.jacobian(q, DOWN) @ rate for q, rate in zip(Q, rates, strict=True)])
    np.testing.assert_allclose(motion.velocity, twists[:, :3], atol=1e-12)
    np.testing.assert_allclose(motion.angular_velocity, twists[:, 3:], atol=1e-12)


def momentum(motion: TipMotion) -> tuple[Array, Array, Array]:
    """Centre of mass, linear momentum and angular momentum about the world's origin of the held body."""
    R = motion.poses[0, :3, :3]
    r = R @ BODY.p_tip_com
    com, velocity = motion.poses[0, :3, 3] + r, motion.velocity[0] + np.cross(motion.angular_velocity[0], r)
    linear = BODY.mass * velocity
    return com, linear, np.cross(com, linear) + R @ BODY.inertia @ R.T @ motion.angular_velocity[0]


def test_wrench_is_the_change_of_momentum_and_the_weight(moving: Motion) -> None:
    for t in (-0.4, 0.0, 0.3):
        now = moving(t, DOWN)
        weight = BODY.mass * GRAVITY * UP
        force = difference(lambda t: momentum(moving(t, DOWN))[1], t) + weight
        turning = difference(lambda t: momentum(moving(t, DOWN))[2], t)
        R, tip = now.poses[0, :3, :3], now.poses[0, :3, 3]
        torque = turning + np.cross(momentum(now)[0], weight) - np.cross(tip, force)
        expected = np.concatenate([R.T @ force, R.T @ torque])
        np.testing.assert_allclose(BODY.wrench(now)[0], expected, atol=1e-6)


def test_wrench_of_a_hanging_body_at_rest_is_its_weight() -> None:
    down = np.eye(4)
    down[:3, :3] = rotation_axis_angle((1.0, 0.0, 0.0), np.pi)
    still = np.zeros((1, 3))
    hanging = HeldBody(0.5, np.array([0.0, 0.02, 0.1]), np.eye(3) * 1e-3)
    wrench = hanging.wrench(TipMotion(down[None], still, still, still, still))[0]
    pull = 0.5 * GRAVITY
    np.testing.assert_allclose(wrench, [0.0, 0.0, -pull, -0.02 * pull, 0.0, 0.0], atol=1e-12)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**31), u=st.floats(-20.0, 20.0), speed=st.floats(0.0, 5.0))
def test_path_wrench_is_that_of_the_timed_motion(arm: Arm, seed: int, u: float, speed: float) -> None:
    rng = np.random.default_rng(seed)
    q, (dq, ddq) = arm.random_seeds(rng, 1), rng.normal(size=(2, 1, arm.n))
    a, b, c = BODY.path_wrench(arm.tip_motion(q, dq, ddq, STRAIGHT))
    timed = arm.tip_motion(q, dq * speed, dq * u + ddq * speed**2, STRAIGHT)
    np.testing.assert_allclose(a * u + b * speed**2 + c, BODY.wrench(timed), atol=1e-9)
