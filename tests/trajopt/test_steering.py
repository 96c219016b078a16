"""Legs between moving states, by what they promise; ruckig as an oracle of how fast one joint can be."""

from __future__ import annotations

import numpy as np
import pytest
import ruckig
from hypothesis import given
from hypothesis import strategies as st

from pickcli.geometry import Array
from pickcli.kernel import (
    JointState,
    ParabolicLimits,
    ParabolicSegment,
    parabolic_accelerations,
    steer_fixed_time,
    steer_min_time,
    steer_via,
)
from pickcli.trajopt.parabolic_segment import TICK, straight_segment
from support import parabolic_reference
from support.parabolic_reference import least_time

FIGURES = (np.array([1.0, 2.2, 3.4]), np.array([2.0, 5.0, 7.0]), np.array([40.0, 100.0, 140.0]), 0.05)
PACE, OWN = ParabolicLimits(*FIGURES), parabolic_reference.ParabolicLimits(*FIGURES)
share = st.floats(-1.0, 1.0)
three = st.tuples(share, share, share).map(np.array)
states = st.builds(lambda q, v: JointState(2 * q, v * PACE.velocity), three, three)


def assert_leads(segment: ParabolicSegment, start: JointState, end: JointState) -> None:
    """From one state to the other within the limits."""
    first, last = segment.state(0.0), segment.state(segment.duration)
    for found, wanted in ((first, start), (last, end)):
        np.testing.assert_allclose(found.q, wanted.q, atol=1e-9)
        np.testing.assert_allclose(found.v, wanted.v, atol=1e-9)
    t = np.linspace(0.0, segment.duration, 200)
    q, v = segment.evaluate(t)
    assert np.all(np.abs(v) <= PACE.velocity * (1 + 1e-8))
    assert np.all(np.abs(parabolic_accelerations([segment])) <= PACE.acceleration * (1 + 1e-8))
    # What it says of velocity and acceleration is what its position does.
    fine = np.linspace(0.0, segment.duration, 2001)
    q, v = segment.evaluate(fine)
    trapezoids = q[0] + np.vstack([np.zeros(3), np.cumsum((v[1:] + v[:-1]) / 2, axis=0)]) * fine[1]
    np.testing.assert_allclose(trapezoids, q, atol=1e-3)


@given(states, states)
def test_the_fastest_leg_leads_from_state_to_state_and_none_is_faster_than_its_slowest_joint(
    start: JointState, end: JointState
) -> None:
    segment = steer_min_time(start, end, PACE, np.inf)
    if segment is None:
        return  # a joint that would have to wait and cannot; from rest there is always one, see below
    assert_leads(segment, start, end)
    assert segment.duration >= least_time(end.q - start.q, start.v, end.v, OWN).max() - TICK


@given(three, three)
def test_from_rest_to_rest_there_is_a_leg_within_two_ticks_of_the_slowest_joints_own_time(
    q0: Array, q1: Array
) -> None:
    segment = steer_min_time(JointState.at_rest(q0), JointState.at_rest(q1), PACE, np.inf)
    assert segment is not None
    slowest = least_time(q1 - q0, np.zeros(3), np.zeros(3), OWN).max()
    assert slowest - 1e-9 <= segment.duration <= max(slowest, TICK) + 4 * TICK


thousandths = st.integers(-1000, 1000).map(lambda k: k / 1000)


@given(thousandths, thousandths, thousandths)
def test_without_pause_a_joint_is_as_fast_as_ruckig_says(d: float, v0: float, v1: float) -> None:
    limits = parabolic_reference.ParabolicLimits(np.ones(1), np.full(1, 2.0), np.full(1, np.inf), 0.0)
    given_, plan = ruckig.InputParameter(1), ruckig.Trajectory(1)
    given_.current_position, given_.target_position = [0.0], [2 * d]
    given_.current_velocity, given_.target_velocity = [v0], [v1]
    given_.max_velocity, given_.max_acceleration = [1.0], [2.0]
    ruckig.Ruckig(1).calculate(given_, plan)
    mine = least_time(np.array([2 * d]), np.array([v0]), np.array([v1]), limits)[0]
    assert mine == pytest.approx(plan.duration, abs=1e-6)


@given(states, states, st.integers(1, 3000))
def test_a_leg_in_a_given_time_takes_that_time(start: JointState, end: JointState, n_ticks: int) -> None:
    segment = steer_fixed_time(start, end, PACE, n_ticks * TICK)
    if segment is not None:
        assert segment.duration == n_ticks * TICK
        assert_leads(segment, start, end)


@given(states, states, st.tuples(st.floats(0, 1), st.floats(0, 1)))
def test_a_part_of_a_leg_is_the_leg_there(
    start: JointState, end: JointState, cut: tuple[float, float]
) -> None:
    segment = steer_min_time(start, end, PACE, np.inf)
    if segment is None:
        return
    low, high = (round(c * segment.duration / TICK) * TICK for c in sorted(cut))
    if high - low < TICK / 2:
        return
    part = segment.part(low, high)
    t = np.linspace(0.0, high - low, 50)
    for found, wanted in zip(part.evaluate(t), segment.evaluate(low + t), strict=True):
        np.testing.assert_allclose(found, wanted, atol=1e-8)


def test_each_joint_bends_where_it_can_and_the_slowest_keeps_its_line() -> None:
    start, end = JointState.at_rest(np.zeros(3)), JointState.at_rest(np.array([1.0, 0.5, 0.1]))
    whole = steer_min_time(start, end, PACE, np.inf)
    assert whole is not None
    half = round(whole.duration / 2 / TICK) * TICK
    here = whole.state(half)
    off = JointState(here.q + np.array([0.05, 0.3, 0.3]), here.v)
    segments = steer_via(start, [off, here], end, PACE, half, whole.duration - half)
    assert segments is not None
    assert_leads(segments[0], start, segments[1].state(0.0))
    assert_leads(segments[1], segments[0].state(half), end)
    np.testing.assert_allclose(segments[1].q0, [here.q[0], off.q[1], off.q[2]], atol=1e-9)


@given(three, three)
def test_a_straight_leg_stays_on_its_line(q0: Array, q1: Array) -> None:
    segment = straight_segment(q0, q1, PACE)
    assert_leads(segment, JointState.at_rest(q0), JointState.at_rest(q1))
    way = q1 - q0
    if np.linalg.norm(way) > 1e-3:
        q, _ = segment.evaluate(np.linspace(0.0, segment.duration, 50))
        along = (q - q0) @ way / (way @ way)
        np.testing.assert_allclose(q, q0 + along[:, None] * way, atol=1e-9)
