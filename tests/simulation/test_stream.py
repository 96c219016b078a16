"""Set points: the whole trajectory at any pace, and broken limits by name."""

from __future__ import annotations

import numpy as np
import pytest

from bench.paces import paused, slowed
from pickcli.cell.robot import Limits
from pickcli.motion.trajectory import Trajectory
from pickcli.simulation.stream import Pace, full_speed, stream, violations

LIMITS = Limits(*(np.array([x]) for x in (-1.0, 1.0, 2.0, 10.0, 100.0)))


def rest_to_rest(distance: float = 0.5, duration: float = 1.0) -> Trajectory:
    zero = np.zeros((2, 1))
    return Trajectory(("j",), np.array([0.0, duration]), np.array([[0.0], [distance]]), zero, zero)


@pytest.mark.parametrize(
    ("pace", "duration"), [(full_speed, 1.0), (slowed(0.5), 2.0), (paused(0.3, 0.7, ramp=0.2), 1.9)]
)
def test_any_pace_reaches_the_end_on_the_same_path(pace: Pace, duration: float) -> None:
    trajectory = rest_to_rest()
    commands = stream(trajectory, 1e-3, pace)
    assert len(commands.points) * 1e-3 == pytest.approx(duration, abs=2e-3)
    assert commands.plan_times[-1] == trajectory.duration
    assert np.all(np.diff(commands.plan_times) >= 0.0)
    assert np.array_equal(commands.points, trajectory.sample(commands.plan_times))


def test_a_trajectory_within_its_limits_breaks_none() -> None:
    # A quintic over 0.5 m in 1 s: 0.94 m/s, 2.9 m/s^2, 30 m/s^3.
    assert violations(stream(rest_to_rest(), 1e-3), ("j",), LIMITS, 1e-3) == ()


@pytest.mark.parametrize(
    ("distance", "duration", "kinds"),
    [
        (1.2, 2.0, {"position"}),
        (0.9, 0.8, {"velocity", "jerk"}),
        (0.5, 0.5, {"acceleration", "jerk"}),
    ],
)
def test_broken_limits_are_named(distance: float, duration: float, kinds: set[str]) -> None:
    found = violations(stream(rest_to_rest(distance, duration), 1e-3), ("j",), LIMITS, 1e-3)
    assert {v.what for v in found} == kinds
    assert all("j:" in str(v) for v in found)


def test_a_lower_speed_scale_is_a_lower_limit() -> None:
    commands = stream(rest_to_rest(), 1e-3)
    assert {v.what for v in violations(commands, ("j",), LIMITS, 1e-3, scale=0.25)} == {
        "velocity",
        "acceleration",
    }
