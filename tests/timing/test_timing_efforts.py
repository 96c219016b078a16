"""The pace under what motors exert: kept at every millisecond, by random motions and weak motors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.cell_file import load_cell
from pickcli.errors import NoPlanError
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.kinematics.arm_dynamics import ArmDynamics
from pickcli.kinematics.held_body import HeldBody
from pickcli.timing.effort_limit import EffortLimit
from pickcli.timing.path_constraint import PathConstraint, PathConstraints
from pickcli.timing.timed_run import TimedRun, time_run
from support.timing_paths import segment
from support.tool_states import DOWN

SEEDS = st.integers(0, 2**31)
ARM = Arm(load_cell("apc2016_delft").robot)
BODY = HeldBody(0.6, np.array([0.02, -0.01, 0.06]), 1e-3 * np.eye(3))
DYNAMICS = ArmDynamics(ARM, DOWN, BODY)
WIDE = replace(ARM.limits, lower=np.full(ARM.n, -50.0), upper=np.full(ARM.n, 50.0))
MILLISECOND = 1e-3
TIMING = 0.03  # share by which two solvers of one timing differ


def random_path(seed: int) -> Array:
    rng = np.random.default_rng(seed)
    start = ARM.random_seeds(rng, 1)[0] * 0.5
    steps = rng.normal(size=(int(rng.integers(1, 5)), ARM.n)) * 0.3
    return np.asarray(start + np.cumsum(np.vstack([np.zeros(ARM.n), steps]), axis=0))


def run_of(waypoints: Array, constraint: PathConstraint | None) -> TimedRun:
    return time_run(ARM.names, [segment(waypoints)], WIDE, constraint=constraint)


def at_every_ms(run: TimedRun) -> Array:
    """Efforts (N, n), Nm or N."""
    q, v, a = run.trajectory.states(np.arange(0.0, run.trajectory.duration, MILLISECOND))
    return DYNAMICS.efforts(q, v, a)


def weakened(free: TimedRun, share: float) -> EffortLimit:
    """Motors that have a share of what the free motion takes beyond what rest does."""
    q = free.trajectory.states(np.arange(0.0, free.trajectory.duration, MILLISECOND))[0]
    resting = np.abs(DYNAMICS.efforts(q, 0.0 * q, 0.0 * q)).max(axis=0)
    moving = np.abs(at_every_ms(free)).max(axis=0)
    return EffortLimit(DYNAMICS, resting + 0.05 + share * np.maximum(moving - resting, 0.0))


@settings(max_examples=25, deadline=None)
@given(seed=SEEDS, share=st.floats(0.3, 1.0))
def test_no_motor_exerts_more_than_it_can_at_any_millisecond(seed: int, share: float) -> None:
    waypoints = random_path(seed)
    free = run_of(waypoints, None)
    motors = weakened(free, share)
    try:
        slowed = run_of(waypoints, motors)
    except NoPlanError as error:
        # Rest was looked at along the blended path, which bends elsewhere than the free motion.
        assert "motors" in str(error)
        return
    assert (np.abs(at_every_ms(slowed)) <= motors.most * (1.0 + 1e-3)).all()
    assert slowed.trajectory.duration >= free.trajectory.duration * (1.0 - TIMING)


def test_a_pace_that_takes_half_the_effort_is_near_the_fastest() -> None:
    """One joint on a straight way: half the acceleration takes sqrt(2) times as long."""
    way = np.zeros((2, ARM.n))
    way[1, 0] = 0.2  # m of the rail, which weight does not load
    free = run_of(way, None)
    most = np.abs(at_every_ms(free)).max(axis=0) + 1e3
    most[0] = np.abs(at_every_ms(free)).max(axis=0)[0] / 2
    slowed = run_of(way, EffortLimit(DYNAMICS, most))
    assert slowed.trajectory.duration < free.trajectory.duration * np.sqrt(2.0) * 1.05
    assert np.abs(at_every_ms(slowed))[:, 0].max() == pytest.approx(most[0], rel=0.05)


@settings(max_examples=40, deadline=None)
@given(seed=SEEDS, share=st.floats(0.05, 2.0))
def test_the_factor_of_time_brings_efforts_just_within_the_limits(seed: int, share: float) -> None:
    rng = np.random.default_rng(seed)
    q, (v, a) = ARM.random_seeds(rng, 20), rng.normal(size=(2, 20, ARM.n)) * 2.0
    resting = np.abs(DYNAMICS.efforts(q, 0.0 * q, 0.0 * q)).max(axis=0)
    motors = EffortLimit(DYNAMICS, resting * 1.01 + share * 20.0)
    factor = motors.time_scale(q, v, a)
    assert (factor >= 1.0).all() and np.isfinite(factor).all()
    ratio = np.abs(DYNAMICS.efforts(q, v / factor[:, None], a / factor[:, None] ** 2) / motors.most).max(
        axis=1
    )
    assert (ratio <= 1.0 + 1e-9).all()
    np.testing.assert_allclose(ratio[factor > 1.0], 1.0, rtol=1e-9)


def test_what_no_motor_holds_at_rest_is_said() -> None:
    way = random_path(3)
    weak = EffortLimit(DYNAMICS, np.full(ARM.n, 1e-2))
    assert not np.isfinite(weak.time_scale(way, 0.0 * way, 0.0 * way)).any()
    told = r"limit broken even at rest: what the motors may exert: \w+ needs [\d.]+ of 0.01 N"
    with pytest.raises(NoPlanError, match=told):
        run_of(way, PathConstraints((weak, EffortLimit(DYNAMICS, np.full(ARM.n, 1e6)))))


@settings(max_examples=20, deadline=None)
@given(seed=SEEDS)
def test_several_constraints_are_kept_at_once(seed: int) -> None:
    rng = np.random.default_rng(seed)
    q, (v, a) = ARM.random_seeds(rng, 10), rng.normal(size=(2, 10, ARM.n))
    parts = [EffortLimit(DYNAMICS, rng.uniform(50.0, 500.0, ARM.n)) for _ in range(2)]
    both = PathConstraints(tuple(parts))
    np.testing.assert_array_equal(
        both.time_scale(q, v, a), np.maximum(*(part.time_scale(q, v, a) for part in parts))
    )
    planes = both.half_planes(q, v, a)
    assert planes.a.shape == planes.b.shape == planes.c.shape == (10, 4 * ARM.n)
    np.testing.assert_array_equal(planes.c[:, : 2 * ARM.n], parts[0].half_planes(q, v, a).c)
