"""Bernstein bounds: never below the truth, and tight."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.motion.trajectory import Trajectory
from pickcli.verification.quintic import control_points, largest, motion, variation


def random_trajectory(seed: int, n: int = 3) -> Trajectory:
    rng = np.random.default_rng(seed)
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.01, 0.5, 6))])
    p, v, a = (rng.normal(size=(7, n)) * k for k in (1.0, 3.0, 20.0))
    return Trajectory(tuple("abcdefgh"[:n]), times, p, v, a)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), derivative=st.integers(0, 3))
def test_the_largest_value_is_bounded_tightly(seed: int, derivative: int) -> None:
    trajectory = random_trajectory(seed)
    # both ends of every piece and 200 times in it: the jerk jumps at the knots
    edges = pairwise(trajectory.times)
    t = np.concatenate([np.linspace(a, np.nextafter(b, a), 400) for a, b in edges])
    seen = trajectory.sample(t, derivative).max(axis=0)
    bound = largest(control_points(trajectory, derivative))
    scale = np.abs(trajectory.sample(t, derivative)).max()
    assert (bound >= seen - 1e-9 * scale).all()
    assert (bound <= seen + 1e-3 * scale).all()


@pytest.mark.parametrize("most", [0, 1, 5])
@pytest.mark.parametrize("derivative", [0, 1, 2, 3])
def test_where_halving_ends_early_the_bound_is_from_above_still(
    monkeypatch: pytest.MonkeyPatch, most: int, derivative: int
) -> None:
    """As many control points as are left are a bound: of the whole pieces, where nothing is halved."""
    monkeypatch.setattr("pickcli.verification.quintic.MOST_PIECES", most)
    for seed in range(10):
        trajectory = random_trajectory(seed)
        points = control_points(trajectory, derivative)
        t = np.linspace(0.0, trajectory.duration, 2000)
        bound, seen = largest(points), trajectory.sample(t, derivative).max(axis=0)
        assert (bound >= seen - 1e-9 * np.abs(seen)).all()
        assert (bound <= points.max(axis=(0, 1)) + 1e-6 * np.abs(seen)).all()


def test_a_known_peak_between_the_points() -> None:
    """Rest to rest, 1 in T: v = 15/8 / T in the middle, a = 10/sqrt(3) / T^2, j = 60 / T^3 at the ends."""
    T = 0.7
    zero = np.zeros((2, 1))
    trajectory = Trajectory(("a",), np.array([0.0, T]), np.array([[0.0], [1.0]]), zero, zero)
    for derivative, peak in ((0, 1.0), (1, 15 / 8 / T), (2, 10 / np.sqrt(3) / T**2), (3, 60 / T**3)):
        assert largest(control_points(trajectory, derivative))[0] == pytest.approx(peak, rel=1e-8)


@pytest.mark.parametrize("far", [1e-4, 1.0, 1e3])
def test_a_bound_is_never_below_a_peak_and_at_most_a_billionth_above(far: float) -> None:
    """Of a billionth of a millionth at least. There and back to rest, the peaks between the points."""
    zero, T = np.zeros((3, 1)), 0.7
    trajectory = Trajectory(("a",), np.array([0.0, T, 2 * T]), np.array([[0.0], [far], [0.0]]), zero, zero)
    for derivative, peak in ((0, far), (1, 15 / 8 * far / T), (2, 10 / np.sqrt(3) * far / T**2)):
        bound = largest(control_points(trajectory, derivative))[0]
        slack = 1e-9 * max(1e-6, peak)
        assert peak + 0.9 * slack <= bound <= peak + 1.2 * slack


def exact_jerk(trajectory: Trajectory, i: int, j: int) -> tuple[Fraction, Fraction]:
    """At the start and the end of piece i, of joint j, in whole numbers."""
    t0, t1 = (Fraction(float(t)) for t in trajectory.times[i : i + 2])
    (p0, p1), (v0, v1), (a0, a1) = (
        [Fraction(float(x)) for x in values[i : i + 2, j]]
        for values in (trajectory.positions, trajectory.velocities, trajectory.accelerations)
    )
    h = t1 - t0
    start = 60 * (p1 - p0) / h**3 - (36 * v0 + 24 * v1) / h**2 - (9 * a0 - 3 * a1) / h
    end = 60 * (p1 - p0) / h**3 - (24 * v0 + 36 * v1) / h**2 - (3 * a0 - 9 * a1) / h
    return start, end


def test_the_jerk_of_short_pieces_is_not_lost_in_rounding() -> None:
    """Pieces of 7 ms far from zero: within 1e-10 of the jerk in whole numbers."""
    t = np.cumsum([0.0, *[1 / 140] * 60])
    p, v, a = np.pi + np.sin(2 * t), 2 * np.cos(2 * t), -4 * np.sin(2 * t)
    trajectory = Trajectory(("a",), t, *(x[:, None] for x in (p, v, a)))
    points = control_points(trajectory, 3)
    for i in range(60):
        start, end = exact_jerk(trajectory, i, 0)
        assert points[i, 0, 0] == pytest.approx(float(start), abs=1e-9)
        assert points[i, -1, 0] == pytest.approx(float(end), abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_motion_is_the_trajectory(seed: int) -> None:
    """At its knots, at its end, anywhere between them and outside of it, with both derivatives."""
    trajectory = random_trajectory(seed)
    between = np.random.default_rng(seed).uniform(0, trajectory.duration, 50)
    times = np.unique(np.concatenate([[-1.0, trajectory.duration + 1.0], trajectory.times, between]))
    for derivative, values in enumerate(motion(trajectory, times)):
        expected = trajectory.sample(times, derivative)
        np.testing.assert_allclose(values, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_way_of_a_joint_is_never_underestimated(seed: int) -> None:
    trajectory = random_trajectory(seed)
    between = np.random.default_rng(seed).uniform(0, trajectory.duration, 5)
    times = np.unique(np.concatenate([trajectory.times, between]))
    bound = variation(*motion(trajectory, times), times)
    for i, (a, b) in enumerate(pairwise(times)):
        way = np.abs(np.diff(trajectory.sample(np.linspace(a, b, 300)), axis=0)).sum(axis=0)
        assert (bound[i] >= way - 1e-9).all()
    # and it is exact for a joint that does not turn back
    fine = np.linspace(0, trajectory.duration, 20001)
    true = np.abs(np.diff(trajectory.sample(fine), axis=0)).sum(axis=0)
    dense = np.unique(np.concatenate([trajectory.times, fine]))
    assert variation(*motion(trajectory, dense), dense).sum(axis=0) == pytest.approx(true, rel=1e-3)
