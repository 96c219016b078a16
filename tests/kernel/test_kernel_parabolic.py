"""Parabolic segments of the kernel against numpy: the same to the last bit."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from pickcli import kernel
from pickcli.geometry import Array
from support import parabolic_reference as reference

SEEDS = st.integers(0, 2**32 - 1)
TICK = reference.TICK


class Case:
    """Random limits of some joints, and states within them, for the kernel and for numpy."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.n = int(self.rng.integers(1, 9))
        a = self.rng.uniform(1.0, 8.0, self.n)
        figures = self.rng.uniform(0.5, 4.0, self.n), a, self.rng.uniform(15.0, 60.0) * a
        pause = float(reference.ticks_up((a / figures[2]).max()))
        self.limits = kernel.ParabolicLimits(*figures, pause)
        self.own = reference.ParabolicLimits(*figures, pause)

    def state(self, is_at_rest: bool = False) -> reference.JointState:
        q, v = self.rng.uniform(-2.0, 2.0, self.n), self.rng.uniform(-1.0, 1.0, self.n) * self.own.velocity
        v[self.rng.random(self.n) < 0.2] = 0.0
        return reference.JointState(q, np.zeros(self.n) if is_at_rest else v)

    def motion(self) -> reference.ParabolicTrajectory:
        """Through a few states, from rest to rest."""
        k = int(self.rng.integers(1, 5))
        states = [self.state(True), *(self.state() for _ in range(k - 1)), self.state(True)]
        segments = [reference.steer_min_time(a, b, self.own, np.inf) for a, b in pairwise(states)]
        assume(all(segment is not None for segment in segments))
        return reference.ParabolicTrajectory(tuple(segment for segment in segments if segment is not None))

    def times(self, motion: reference.ParabolicTrajectory) -> tuple[float, float]:
        """Two times of a motion on ticks."""
        first, last = np.sort(self.rng.integers(0, round(motion.duration / TICK) + 1, 2))
        return float(first * TICK), float(last * TICK)


def native(thing: reference.JointState) -> kernel.JointState:
    return kernel.JointState(thing.q, thing.v)


def native_segment(s: reference.ParabolicSegment) -> kernel.ParabolicSegment:
    return kernel.ParabolicSegment(s.q0, s.v0, s.speed, s.v1, s.up, s.down, s.duration)


def assert_same_segments(
    found: Sequence[kernel.ParabolicSegment], expected: Sequence[reference.ParabolicSegment]
) -> None:
    assert len(found) == len(expected)
    for a, b in zip(found, expected, strict=True):
        assert a.duration == b.duration
        for name in ("q0", "speed", "up", "down"):
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
        t = np.linspace(0.0, b.duration, 20)
        for rows, wanted in zip(a.evaluate(t), b.evaluate(t), strict=True):
            np.testing.assert_array_equal(rows, wanted)


@given(SEEDS)
def test_steering_is_that_of_the_reference(seed: int) -> None:
    case = Case(seed)
    start, middle, end = case.state(seed % 3 == 0), case.state(), case.state(seed % 2 == 0)
    for at_most in (np.inf, 1.0):
        fastest = reference.steer_min_time(start, end, case.own, at_most)
        found = kernel.steer_min_time(native(start), native(end), case.limits, at_most)
        assert_same_segments([found] if found else [], [fastest] if fastest else [])
    duration = float(case.rng.integers(1, 4000)) * TICK
    timed = reference.steer_fixed_time(start, end, case.own, duration)
    found = kernel.steer_fixed_time(native(start), native(end), case.limits, duration)
    assert_same_segments([found] if found else [], [timed] if timed else [])
    middles = [middle, case.state(), reference.JointState((start.q + end.q) / 2, (start.v + end.v) / 2)]
    back = float(case.rng.integers(1, 4000)) * TICK
    via = reference.steer_via(start, middles, end, case.own, duration, back)
    choices = [native(each) for each in middles]
    both = kernel.steer_via(native(start), choices, native(end), case.limits, duration, back)
    assert_same_segments(both or (), via or ())


@given(SEEDS)
def test_motions_are_cut_and_joined_as_by_the_reference(seed: int) -> None:
    case = Case(seed)
    expected = case.motion()
    motion = kernel.ParabolicTrajectory([native_segment(s) for s in expected.segments])
    assert motion.duration == expected.duration
    start, end = case.times(expected)
    assert_same_segments(motion.between(start, end), expected.between(start, end))
    for t in (start, end):
        np.testing.assert_array_equal(motion.state(t).q, expected.state(t).q)
        np.testing.assert_array_equal(motion.state(t).v, expected.state(t).v)
    assume(end > start)
    other = expected.between(start, end)
    replaced = motion.replaced(start, end, [native_segment(s) for s in other])
    assert_same_segments(replaced.segments, expected.replaced(start, end, other).segments)


@given(SEEDS)
def test_curves_are_those_of_the_reference(seed: int) -> None:
    case = Case(seed)
    motion = case.motion()
    segments = [native_segment(s) for s in motion.segments]
    for step in (0.04, 0.01):
        for found, expected in zip(
            kernel.tube(segments, step), reference.tube(motion.segments, step), strict=True
        ):
            np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(
        kernel.parabolic_accelerations(segments), reference.accelerations(motion.segments)
    )
    t = np.sort(case.rng.uniform(0.0, motion.duration, 30))
    ends = np.cumsum([segment.duration for segment in motion.segments])
    t = np.sort(np.concatenate([t, ends]))
    np.testing.assert_array_equal(
        kernel.parabolic_positions(segments, t), reference.positions(motion.segments, t)
    )
    assert kernel.jerk_window(segments, case.limits) == reference.jerk_window(motion.segments, case.own)
    whole = kernel.ParabolicTrajectory(segments)
    assert whole.total(case.limits) == motion.total(case.own)


def two_joints(q: Array) -> kernel.ParabolicSegment:
    none = np.zeros(2)
    return kernel.ParabolicSegment(q, none, none, none, none, none, 0.01)


def test_wrong_arguments_are_named() -> None:
    two = two_joints(np.zeros(2))
    limits = kernel.ParabolicLimits(np.ones(3), np.ones(3), np.ones(3), 0.0)
    rest = kernel.JointState.at_rest(np.zeros(2))
    for wrong, said in (
        (lambda: kernel.JointState(np.zeros(2), np.zeros(3)), "v: shape"),
        (lambda: kernel.ParabolicLimits(np.ones(2), np.zeros(2), np.ones(2), 0.0), "positive"),
        (lambda: kernel.ParabolicLimits(np.ones(2), np.ones(2), np.ones(2), -1.0), "pause"),
        (lambda: kernel.steer_min_time(rest, rest, limits, 1.0), "same joints"),
        (lambda: kernel.tube([], 0.1), "one at least"),
        (lambda: kernel.tube([two], 0.0), "step"),
        (lambda: kernel.ParabolicTrajectory([]), "one at least"),
        (lambda: kernel.parabolic_positions([two], np.array([1.0, 0.0])), "not increasing"),
        (lambda: kernel.jerk_window([two], limits), "same joints"),
    ):
        with pytest.raises(ValueError, match=said):
            wrong()
