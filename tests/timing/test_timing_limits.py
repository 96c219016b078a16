"""The strict check: nothing between the points escapes it, and it names what it found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.errors import LimitError
from pickcli.motion.trajectory import Trajectory
from pickcli.timing.limit_check import PeakRatio, check_limits, measure_limits, peaks
from support.timing_paths import limits, names, random_walk, timed


def wild(seed: int, n_points: int, n: int) -> Trajectory:
    """Random points, velocities and accelerations: quintics with extremes anywhere."""
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(3, n_points, n))
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 2.0, n_points - 1))])
    return Trajectory(names(n), times, *rows)


@given(st.integers(0, 10**6), st.integers(2, 6), st.integers(1, 8))
@settings(max_examples=100, deadline=None)
def test_peaks_bound_what_dense_samples_find(seed: int, n_points: int, n: int) -> None:
    trajectory = wild(seed, n_points, n)
    bounds = peaks(trajectory)
    for i in range(n_points - 1):
        # The right end of a piece belongs to the next one for jerk: stay inside.
        t = np.linspace(trajectory.times[i], trajectory.times[i + 1] - 1e-9, 400)
        for derivative, bound in enumerate(bounds, start=1):
            found = np.abs(trajectory.sample(t, derivative)).max(axis=0)
            assert np.all(found <= bound[i] * (1.0 + 1e-9) + 1e-9)
            if derivative > 1:  # acceleration and jerk are exact
                assert np.all(found >= bound[i] * 0.99 - 1e-6)


def test_stretch_is_just_enough() -> None:
    trajectory = timed(random_walk(0, 4)).trajectory
    slow = limits()
    slow = replace(slow, velocity=slow.velocity / 3, acceleration=slow.acceleration / 5, jerk=slow.jerk / 7)
    factor = measure_limits(trajectory, slow).time_scale
    stretched = Trajectory(
        trajectory.joint_names,
        trajectory.times * factor,
        trajectory.positions,
        trajectory.velocities / factor,
        trajectory.accelerations / factor**2,
    )
    report = check_limits(stretched, slow)
    assert max(w.ratio for w in (report.velocity, report.acceleration, report.jerk)) == pytest.approx(1.0)


@pytest.mark.parametrize("quantity", ["velocity", "acceleration", "jerk"])
def test_violation_names_quantity_joint_and_time(quantity: str) -> None:
    trajectory = timed(random_walk(0, 4)).trajectory
    bound = getattr(limits(), quantity).copy()
    bound[3] *= 1e-2
    with pytest.raises(LimitError, match=rf"{quantity} of joint joint_3 .* at \d+\.\d+ s"):
        check_limits(trajectory, replace(limits(), **{quantity: bound}))


def test_position_limit_is_checked() -> None:
    trajectory = timed(random_walk(0, 4)).trajectory
    upper = np.full(8, 50.0)
    upper[2] = trajectory.positions[:, 2].max() - 1e-3
    with pytest.raises(LimitError, match=r"joint_2 is 0\.001 outside"):
        check_limits(trajectory, replace(limits(), upper=upper))


def test_scale_may_differ_from_piece_to_piece() -> None:
    trajectory = timed(random_walk(0, 3)).trajectory
    scale = np.ones(len(trajectory.times) - 1)
    check_limits(trajectory, limits(), scale)
    scale[len(scale) // 3] = 1e-3
    with pytest.raises(LimitError):
        check_limits(trajectory, limits(), scale)


def test_moving_ends_and_bad_times_are_refused() -> None:
    good = timed(random_walk(0, 3)).trajectory
    times = good.times.copy()
    times[5] = times[4]
    with pytest.raises(LimitError, match="increase strictly"):
        check_limits(replace(good, times=times), limits())
    velocities = good.velocities.copy()
    velocities[-1] = 1e-6
    with pytest.raises(LimitError, match="at rest"):
        check_limits(replace(good, velocities=velocities), limits())
    accelerations = good.accelerations.copy()
    accelerations[7] = np.nan
    with pytest.raises(LimitError):
        check_limits(replace(good, accelerations=accelerations), limits())


def test_a_peak_says_which_joint_and_when() -> None:
    assert str(PeakRatio(0.9744, "joint_u", 2.83)) == "joint_u at 0.974 of its limit at 2.830 s"
