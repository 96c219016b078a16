"""The motion of an axis with a belt: a sum that is exact, within limits, and at rest relative to the belt."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.motion.trajectory import Trajectory
from pickcli.timing.limit_check import peaks
from pickcli.timing.line_tracking import (
    TrackedMotion,
    ramp_time,
    relative_to_belt,
    shifted,
)

MOTION = TrackedMotion(0, 0.33, 1.0, 1.4, 2.0, 2.5)


def at_rest(motion: TrackedMotion) -> Trajectory:
    """Two joints: the first rests during the ramps and goes 0.1 m in between, the second moves before."""
    t = np.array(
        [0.0, motion.t_start, motion.t_synchronous, motion.t_leaving, motion.t_end, motion.t_end + 1.0]
    )
    q = np.array([[0.2, 0.0], [0.2, 0.7], [0.2, 0.7], [0.3, 0.7], [0.3, 0.7], [0.1, 0.2]])
    return Trajectory(("rail", "turn"), t, q, np.zeros_like(q), np.zeros_like(q))


@given(st.floats(-2.0, 2.0).filter(lambda v: abs(v) > 1e-3), st.floats(0.0, 4.0))
def test_the_sum_is_exact_between_the_points_too(speed: float, t: float) -> None:
    motion = TrackedMotion(0, speed, 1.0, 1.4, 2.0, 2.5)
    relative = at_rest(motion)
    whole = motion.added_to(relative)
    at = np.array([t])
    t_inside = np.clip(at, 0.0, whole.duration)
    for derivative, offset in enumerate(motion.offset(t_inside)[:2]):
        expected = relative.sample(t_inside, derivative)[:, 0] + offset
        assert whole.sample(t_inside, derivative)[:, 0] == pytest.approx(expected, abs=1e-9)
    assert np.allclose(whole.sample(at), np.column_stack([whole.sample(at)[:, 0], relative.sample(at)[:, 1]]))


def test_the_offset_is_the_integral_of_its_derivatives() -> None:
    t = np.linspace(0.0, 4.0, 40_001)
    positions, velocities, accelerations = MOTION.offset(t)
    step = t[1] - t[0]
    assert np.allclose(np.diff(positions) / step, (velocities[1:] + velocities[:-1]) / 2, atol=1e-7)
    assert np.allclose(np.diff(velocities) / step, (accelerations[1:] + accelerations[:-1]) / 2, atol=1e-4)
    assert (velocities[t <= 1.0] == 0.0).all() and (velocities[t >= 2.5] == 0.0).all()
    assert np.allclose(velocities[(t >= 1.4) & (t < 2.0)], 0.33)


def test_seen_from_the_belt_the_axis_moves_as_if_that_stood() -> None:
    relative = at_rest(MOTION)
    seen = relative_to_belt(MOTION.added_to(relative), 0, 0.33, 1.4)
    for t in (1.4, 1.7, 2.0):
        before, after = relative.sample(t)[0, 0], seen.sample(t)[0, 0]
        assert after - before == pytest.approx(float(MOTION.offset(np.array([1.4]))[0][0]))


@given(st.floats(0.05, 1.0), st.floats(0.5, 10.0), st.floats(10.0, 500.0))
def test_ramps_keep_the_limits(speed: float, acceleration: float, jerk: float) -> None:
    ramp = ramp_time(speed, acceleration, jerk)
    motion = TrackedMotion(0, speed, 1.0, 1.0 + ramp, 2.0 + ramp, 2.0 + 2 * ramp)
    still = Trajectory(
        ("rail",), np.array([0.0, 1.0, 1.0 + ramp, 2.0 + ramp, 2.0 + 2 * ramp]), *3 * [np.zeros((5, 1))]
    )
    found = motion.added_to(still)
    velocity, most, jerks = (float(peak.max()) for peak in peaks(found))
    assert velocity == pytest.approx(speed)
    assert most <= acceleration * (1 + 1e-6) and jerks <= jerk * (1 + 1e-6)
    way = 2 * 0.5 * speed * ramp + speed * 1.0
    assert found.positions[-1, 0] == pytest.approx(way) and found.velocities[-1, 0] == 0.0


def test_a_shift_moves_one_axis() -> None:
    moved = shifted(at_rest(MOTION), 1, 0.4)
    assert np.allclose(moved.positions - at_rest(MOTION).positions, [0.0, 0.4])
