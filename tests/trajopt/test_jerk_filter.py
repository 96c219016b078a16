"""From segments to trajectories that keep their jerk limits."""

from __future__ import annotations

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from pickcli.cell.robot import Limits
from pickcli.geometry import Array
from pickcli.kernel import (
    JointState,
    ParabolicSegment,
    ParabolicTrajectory,
    jerk_window,
    parabolic_accelerations,
    steer_min_time,
    tube,
)
from pickcli.timing.limit_check import measure_limits
from pickcli.trajopt.jerk_filter import filter_jerk
from pickcli.trajopt.parabolic_segment import parabolic_limits, resting_segment, straight_segment
from pickcli.trajopt.time_lower_bound import lower_bound

LIMITS = Limits(
    np.full(2, -9.0), np.full(2, 9.0), np.array([1.0, 2.2]), np.array([2.0, 5.0]), np.array([40.0, 100.0])
)
PACE = parabolic_limits(LIMITS)
NAMES = ("a", "b")
share = st.floats(-1.0, 1.0)
two = st.tuples(share, share).map(np.array)


def from_rest_to_rest(q0: Array, q1: Array) -> ParabolicSegment:
    segment = steer_min_time(JointState.at_rest(q0), JointState.at_rest(q1), PACE, np.inf)
    assert segment is not None
    return segment


@given(two, two, two, st.sampled_from([0.001, 0.02, 0.05]))
@settings(max_examples=30)
def test_the_average_keeps_every_limit_and_its_ends(a: Array, b: Array, c: Array, rests: float) -> None:
    assume(min(np.abs(b - a).max(), np.abs(c - b).max()) > 1e-3)
    motion = ParabolicTrajectory(
        (straight_segment(a, b, PACE), resting_segment(b, rests), from_rest_to_rest(b, c))
    )
    timed = filter_jerk(NAMES, motion, c, PACE, LIMITS)
    assert measure_limits(timed, LIMITS).time_scale <= 1.0 + 1e-6
    np.testing.assert_array_equal(timed.positions[[0, -1]], [a, c])
    assert not timed.velocities[[0, -1]].any() and not timed.accelerations[[0, -1]].any()
    assert timed.duration <= motion.total(PACE) * (1 + 1e-4)


@given(two, two)
@settings(max_examples=30)
def test_the_average_lies_near_the_motion_half_a_pause_earlier(a: Array, b: Array) -> None:
    assume(np.abs(b - a).max() > 1e-3)
    motion = ParabolicTrajectory((from_rest_to_rest(a, b),))
    timed = filter_jerk(NAMES, motion, b, PACE, LIMITS)
    for t in np.linspace(PACE.pause, motion.duration - PACE.pause, 9):
        if 0.0 < t < motion.duration:
            there = timed.sample(t + PACE.pause / 2)[0]
            off = np.abs(there - motion.state(float(t)).q)
            assert np.all(off <= LIMITS.acceleration * PACE.pause**2 / 24 + 1e-4)


def test_over_a_long_way_the_average_takes_the_time_of_the_bound() -> None:
    a, b = np.zeros(2), np.array([1.3, 0.4])
    timed = filter_jerk(NAMES, ParabolicTrajectory((from_rest_to_rest(a, b),)), b, PACE, LIMITS)
    bound = lower_bound(LIMITS, a, b)
    assert bound <= timed.duration <= bound + 0.004


def test_a_ramp_down_right_before_a_ramp_up_needs_a_longer_average_unless_there_is_a_rest() -> None:
    a, b, c = np.zeros(2), np.array([1.0, 1.0]), np.array([2.0, 2.0])
    first, second = straight_segment(a, b, PACE), straight_segment(b, c, PACE)
    assert jerk_window((first, second), PACE) == 2 * PACE.pause
    assert jerk_window((first, resting_segment(b, PACE.pause), second), PACE) == PACE.pause


@given(two, two, st.sampled_from([0.04, 0.01]))
@settings(max_examples=30)
def test_legs_stay_in_their_tube(a: Array, b: Array, step: float) -> None:
    segment = from_rest_to_rest(a, b)
    Q, slack = tube((segment,), step)
    n = len(slack)
    for k in range(n):
        u = np.linspace(0.0, 1.0, 7)
        q, _ = segment.evaluate((k + u) * segment.duration / n)
        chord = Q[k] + u[:, None] * (Q[k + 1] - Q[k])
        assert np.all(np.abs(q - chord) <= slack[k] + 1e-12)


def test_a_motion_can_be_cut_and_joined() -> None:
    a, b, c = np.zeros(2), np.array([1.0, -0.5]), np.array([0.2, 0.3])
    motion = ParabolicTrajectory(
        (straight_segment(a, b, PACE), resting_segment(b, PACE.pause), from_rest_to_rest(b, c))
    )
    joined = ParabolicTrajectory(
        motion.between(0.0, 0.3) + motion.between(0.3, 1.2) + motion.between(1.2, motion.duration)
    )
    assert joined.duration == motion.duration
    for t in np.linspace(0.0, motion.duration, 40):
        np.testing.assert_allclose(joined.state(float(t)).q, motion.state(float(t)).q, atol=1e-9)
    found, expected = (parabolic_accelerations(each.segments) for each in (joined, motion))
    np.testing.assert_allclose(found, expected, atol=1e-7)
