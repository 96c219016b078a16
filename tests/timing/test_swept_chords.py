"""Edges that cover a motion wherever it is displaced along one of its axes."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.motion.trajectory import Trajectory
from pickcli.timing.trajectory_chords import swept_chords
from pickcli.timing.trajectory_sampling import divided


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.integers(0, 2))
def test_every_displaced_state_is_within_the_slack_of_its_edge(seed: int, axis: int) -> None:
    rng = np.random.default_rng(seed)
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.01, 0.5, 5))])
    motion = Trajectory(("a", "b", "c"), times, *rng.normal(size=(3, 6, 3)))
    low, high = np.sort(rng.normal(size=(2, 5)), axis=0)
    ends, slack = swept_chords(motion, axis, low, high)
    assert ends.shape == (10, 3) and slack.shape == (9, 3)
    for k in range(5):
        t = np.linspace(times[k], times[k + 1], 30)
        states = np.repeat(motion.sample(t), 3, axis=0)
        states[:, axis] += np.tile([low[k], (low[k] + high[k]) / 2, high[k]], 30)
        edge = ends[2 * k : 2 * k + 2]
        beyond = np.maximum(edge.min(axis=0) - states, states - edge.max(axis=0))
        assert (beyond <= slack[2 * k] + 1e-9).all()


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 6))
def test_a_divided_motion_is_the_same_with_less_slack(seed: int, parts: int) -> None:
    rng = np.random.default_rng(seed)
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.1, 0.5, 4))])
    motion = Trajectory(("a", "b"), times, *rng.normal(size=(3, 5, 2)))
    finer = divided(motion, parts)
    t = np.linspace(0.0, motion.duration, 200)
    for derivative in range(3):
        np.testing.assert_allclose(finer.sample(t, derivative), motion.sample(t, derivative), atol=1e-8)
    assert len(finer.times) == 4 * parts + 1 and np.allclose(finer.times[::parts], times)
    none = np.zeros(4)
    coarse = swept_chords(motion, 0, none, none)[1][::2, 1]
    fine = swept_chords(finer, 0, np.repeat(none, parts), np.repeat(none, parts))[1][::2, 1]
    assert (fine.reshape(4, parts).max(axis=1) <= coarse + 1e-9).all()
