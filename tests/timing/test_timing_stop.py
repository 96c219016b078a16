"""Protective stop and resume: same path, within all limits, at rest where they say."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory
from pickcli.timing.concatenation import concatenate
from pickcli.timing.limit_check import check_limits
from pickcli.timing.stopping_trajectory import resume, stop
from support.timing_paths import dense_curve, limits, random_walk, timed

TRAJECTORIES = [
    timed(random_walk(0, 4), 0.05).trajectory,
    timed(dense_curve(1, 30), 0.003).trajectory,
    timed(random_walk(2, 2, size=0.02)).trajectory,
    concatenate([timed(random_walk(3, 3)), timed(random_walk(3, 3)[::-1])], [0.4]).trajectory,
]


def distance_to_path(q: Array, trajectory: Trajectory) -> float:
    """Largest distance of points to a trajectory's path, by brute force."""
    t = np.linspace(0.0, trajectory.duration, 4000)
    path = trajectory.sample(t)
    step = float(np.linalg.norm(np.diff(path, axis=0), axis=1).max()) / 2
    nearest = max(float(np.linalg.norm(path - one, axis=1).min()) for one in q)
    return max(nearest - step, 0.0)


@given(st.sampled_from(range(len(TRAJECTORIES))), st.floats(0.0, 1.0))
@settings(max_examples=60, deadline=None)
def test_stop_and_resume_keep_path_and_limits(which: int, share: float) -> None:
    trajectory = TRAJECTORIES[which]
    at = share * trajectory.duration
    halted = stop(trajectory, at, limits())
    check_limits(halted.trajectory, limits())
    before = np.linspace(0.0, at, 50)
    assert np.allclose(halted.trajectory.sample(before), trajectory.sample(before), atol=1e-5)
    assert np.allclose(halted.trajectory.positions[-1], trajectory.sample(halted.path_time)[0], atol=1e-9)
    assert at <= halted.path_time + 1e-9

    onwards = resume(trajectory, halted.path_time, limits()).trajectory
    check_limits(onwards, limits())
    assert np.allclose(onwards.positions[0], halted.trajectory.positions[-1], atol=1e-9)
    assert np.allclose(onwards.positions[-1], trajectory.positions[-1], atol=1e-9)
    for part in (halted.trajectory, onwards):
        t = np.linspace(0.0, part.duration, 60)
        assert distance_to_path(part.sample(t), trajectory) < 1e-5


@pytest.mark.parametrize("share", np.linspace(0.05, 0.9, 8))
def test_stop_is_quick(share: float) -> None:
    """Never later than the motion's own end, and for a moving arm within about a second."""
    trajectory = TRAJECTORIES[0]
    at = share * trajectory.duration
    halted = stop(trajectory, at, limits())
    assert halted.trajectory.duration <= trajectory.duration
    assert halted.trajectory.duration - at < 1.0


def test_stop_at_rest_stays_there() -> None:
    joined = TRAJECTORIES[3]
    middle = joined.duration / 2  # both runs last as long as each other
    halted = stop(joined, middle, limits())
    assert np.abs(halted.trajectory.positions[-1] - joined.sample(middle)[0]).max() < 1e-14


def test_resume_soon_runs_at_the_old_pace() -> None:
    trajectory = TRAJECTORIES[0]
    halted = stop(trajectory, 0.4 * trajectory.duration, limits())
    onwards = resume(trajectory, halted.path_time, limits()).trajectory
    assert onwards.duration < trajectory.duration - halted.path_time + 0.7


def test_stop_after_the_end_is_the_motion_itself() -> None:
    trajectory = TRAJECTORIES[0]
    assert stop(trajectory, trajectory.duration, limits()).trajectory is trajectory
    assert resume(trajectory, trajectory.duration, limits()).trajectory.duration < 1.0
