"""Bernstein bounds: never below the truth, and tight."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.motion.trajectory import Trajectory
from pickcli.verification.quintic import control_points, largest, variation


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


def test_a_known_peak_between_the_points() -> None:
    """Rest to rest, 1 in T: v = 15/8 / T in the middle, a = 10/sqrt(3) / T^2, j = 60 / T^3 at the ends."""
    T = 0.7
    zero = np.zeros((2, 1))
    trajectory = Trajectory(("a",), np.array([0.0, T]), np.array([[0.0], [1.0]]), zero, zero)
    for derivative, peak in ((0, 1.0), (1, 15 / 8 / T), (2, 10 / np.sqrt(3) / T**2), (3, 60 / T**3)):
        assert largest(control_points(trajectory, derivative))[0] == pytest.approx(peak, rel=1e-8)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_way_of_a_joint_is_never_underestimated(seed: int) -> None:
    trajectory = random_trajectory(seed)
    between = np.random.default_rng(seed).uniform(0, trajectory.duration, 5)
    times = np.unique(np.concatenate([trajectory.times, between]))
    bound = variation(trajectory, times)
    for i, (a, b) in enumerate(pairwise(times)):
        way = np.abs(np.diff(trajectory.sample(np.linspace(a, b, 300)), axis=0)).sum(axis=0)
        assert (bound[i] >= way - 1e-9).all()
    # and it is exact for a joint that does not turn back
    fine = np.linspace(0, trajectory.duration, 20001)
    true = np.abs(np.diff(trajectory.sample(fine), axis=0)).sum(axis=0)
    dense = np.unique(np.concatenate([trajectory.times, fine]))
    assert variation(trajectory, dense).sum(axis=0) == pytest.approx(true, rel=1e-3)
