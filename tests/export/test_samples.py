"""Samples: whole nanoseconds, strictly increasing, on the motion, at rest at its end."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from pickcli.errors import InputError
from pickcli.export.samples import (
    MAX_RATE,
    MIN_RATE,
    SECOND,
    interpolation_error,
    sampled,
    stamp,
    to_nanoseconds,
)
from pickcli.motion.trajectory import Trajectory
from support.exported_motions import trajectories

AT_REST = np.zeros((2, 2))


@given(trajectories(), st.none() | st.floats(MIN_RATE, MAX_RATE))
@example(Trajectory(("a", "b"), np.array([0.0, 1e-10]), AT_REST, AT_REST, AT_REST), 1.0)
def test_times_increase_from_0_to_the_end_at_rest(trajectory: Trajectory, rate: float | None) -> None:
    samples = sampled(trajectory, rate)
    assert samples.nanoseconds[0] == 0 and np.all(np.diff(samples.nanoseconds) > 0)
    assert samples.nanoseconds[-1] == round(trajectory.duration * SECOND)
    for rows in (samples.velocities, samples.accelerations):
        assert not rows[-1].any()
    np.testing.assert_array_equal(samples.positions[-1], trajectory.positions[-1])


@given(trajectories())
def test_own_points_are_kept_bit_for_bit(trajectory: Trajectory) -> None:
    samples = sampled(trajectory, None)
    kept = [tuple(row) for row in np.hstack([samples.positions, samples.velocities, samples.accelerations])]
    rows = np.hstack([trajectory.positions, trajectory.velocities, trajectory.accelerations])
    every = [tuple(row) for row in rows]
    assert [row for row in kept if row not in every] == []
    apart = np.diff(np.rint(trajectory.times * SECOND)) > 0
    assert len(kept) == 1 + int(apart.sum())
    if apart.all():
        assert kept == every


@given(trajectories(), st.floats(MIN_RATE, MAX_RATE))
def test_samples_of_a_rate_lie_on_the_motion_a_period_apart(trajectory: Trajectory, rate: float) -> None:
    samples, period = sampled(trajectory, rate), SECOND / rate
    for derivative, rows in enumerate((samples.positions, samples.velocities, samples.accelerations)):
        expected = trajectory.sample(samples.nanoseconds[:-1] / SECOND, derivative)
        np.testing.assert_allclose(rows[:-1], expected, rtol=0.0, atol=1e-9)
    gaps = np.diff(samples.nanoseconds)
    assert np.all(np.abs(gaps[:-1] - period) <= 1.0)
    if len(gaps) > 1:
        assert period / 2 - 1.0 <= gaps[-1] <= 1.5 * period + 1.0


@pytest.mark.parametrize("rate", [0.0, -1.0, 0.99, 1000.1, 1e9, float("nan"), float("inf")])
def test_rates_out_of_bounds_are_refused(rate: float) -> None:
    still = np.zeros((2, 1))
    with pytest.raises(InputError, match=r"rate: .* is not between 1 and 1000; name one that is"):
        sampled(Trajectory(("a",), np.array([0.0, 1.0]), still, still, still), rate)


@given(st.integers(0, 300 * SECOND))
def test_a_stamp_holds_every_nanosecond(nanoseconds: int) -> None:
    told = stamp(nanoseconds)
    assert told["sec"] * SECOND + told["nanosec"] == nanoseconds and 0 <= told["nanosec"] < SECOND


def test_times_that_are_negative_by_rounding_are_0() -> None:
    assert to_nanoseconds(-1e-10) == 0 and to_nanoseconds(0.0235) == 23_500_000


def test_interpolation_errs_as_a_dense_comparison_says() -> None:
    times = np.linspace(0.0, 1.0, 101)
    bell = (1.0 - np.cos(2 * np.pi * times))[:, None]
    slope, bend = 2 * np.pi * np.sin(2 * np.pi * times), 4 * np.pi**2 * np.cos(2 * np.pi * times)
    slope[[0, -1]] = bend[[0, -1]] = 0.0
    rest = np.zeros_like(bell)
    motion = Trajectory(
        ("still", "bell"),
        times,
        np.hstack([rest, bell]),
        *(np.hstack([rest, r[:, None]]) for r in (slope, bend)),
    )
    ends = sampled(motion, 1.0)
    assert len(ends.nanoseconds) == 2
    error, joint = interpolation_error(motion, ends)
    assert (round(error, 9), joint) == (2.0, 1)  # from rest to rest a quintic stays where the bell rises to 2
    fine, _ = interpolation_error(motion, sampled(motion, 100.0))
    assert fine < 1e-9
