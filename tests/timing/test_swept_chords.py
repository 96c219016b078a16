"""Edges that cover a motion wherever it is displaced along one of its axes."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.motion.trajectory import Trajectory
from pickcli.timing.trajectory_chords import swept_chords


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
