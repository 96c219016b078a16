"""Runs joined with rests, and the chords that prove the result."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.motion.trajectory import Trajectory
from pickcli.timing.concatenation import concatenate, delayed
from pickcli.timing.limit_check import check_limits
from pickcli.timing.trajectory_chords import trajectory_chords
from support.timing_paths import limits, names, random_walk, timed


def test_joined_runs_rest_exactly_in_between() -> None:
    path = random_walk(0, 5)
    runs = [timed(path[:3]), timed(path[2:])]
    joined = concatenate(runs, [0.5])
    trajectory = joined.trajectory
    check_limits(trajectory, limits(), joined.piece_scales)
    assert np.array_equal(trajectory.positions[[0, -1]], path[[0, -1]])
    assert joined.starts[1] - joined.ends[0] == pytest.approx(0.5)
    rest = trajectory.sample(np.linspace(joined.ends[0], joined.starts[1], 50))
    assert np.abs(rest - path[2]).max() < 1e-14
    assert np.all(np.diff(trajectory.times) > 0.0)
    # A rest belongs to the part before it.
    assert joined.part_times.tolist() == [0.0, joined.starts[1], trajectory.duration]


def test_each_run_is_itself_within_the_whole() -> None:
    path = random_walk(1, 5)
    runs = [timed(path[:3]), timed(path[2:])]
    joined = concatenate(runs, [0.2])
    for run, start in zip(runs, joined.starts, strict=True):
        t = np.linspace(1e-6, run.trajectory.duration - 1e-6, 200)
        for derivative in range(3):
            here = joined.trajectory.sample(t + start, derivative)
            assert np.allclose(here, run.trajectory.sample(t, derivative), atol=1e-8)


def test_no_rest_between_runs_leaves_no_piece_of_no_length() -> None:
    path = random_walk(0, 5)
    trajectory = concatenate([timed(path[:3]), timed(path[2:])], [0.0]).trajectory
    assert np.diff(trajectory.times).min() > 1e-4


def test_runs_that_do_not_join_are_refused() -> None:
    with pytest.raises(ValueError, match="starts"):
        concatenate([timed(random_walk(0, 3)), timed(random_walk(1, 3))], [0.1])
    with pytest.raises(ValueError, match="need 0 rests"):
        concatenate([timed(random_walk(0, 3))], [0.1])


def test_delayed_holds_still_first() -> None:
    trajectory = timed(random_walk(0, 3)).trajectory
    late = delayed(trajectory, 1.5)
    assert late.duration == pytest.approx(trajectory.duration + 1.5)
    assert np.ptp(late.sample(np.linspace(0.0, 1.5, 20)), axis=0).max() < 1e-14
    assert np.allclose(late.sample(1.5 + 0.3), trajectory.sample(0.3))
    assert delayed(trajectory, 0.0) is trajectory


@given(st.integers(0, 10**6), st.integers(2, 5), st.integers(1, 8))
@settings(max_examples=80, deadline=None)
def test_chords_contain_any_trajectory(seed: int, n_points: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(3, n_points, n))
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 1.0, n_points - 1))])
    trajectory = Trajectory(names(n), times, *rows)
    chords, slack = trajectory_chords(trajectory)
    for k in range(n_points - 1):
        u = np.linspace(0.0, 1.0, 100)[:, None]
        q = trajectory.sample(times[k] + u[:, 0] * (times[k + 1] - times[k]))
        assert np.all(np.abs(q - (chords[k] + u * (chords[k + 1] - chords[k]))) <= slack[k] + 1e-9)


def test_chords_of_a_timed_run_are_tight() -> None:
    """Tight enough to prove with: less than 0.1 mm at a metre from the joint."""
    _, slack = trajectory_chords(timed(random_walk(0, 4)).trajectory)
    assert slack.max() < 1e-4
