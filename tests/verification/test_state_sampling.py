"""States of a motion: near enough to each other, at all times that are asked for, where the motion is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory
from pickcli.verification import state_sampling
from pickcli.verification.forward_kinematics import link_poses
from pickcli.verification.state_sampling import MAX_STEP, States, sample_states
from support.handmade_plans import cell
from support.rail_motions import HOME, rail

NONE = np.empty(0)
N = len(HOME)


def shaking(seed: int) -> Trajectory:
    """All joints go this way and that for three seconds."""
    rng = np.random.default_rng(seed)
    times = np.array([0.0, 0.4, 0.5, 1.7, 3.0])
    p, v, a = (rng.normal(size=(5, N)) * k for k in (0.1, 0.3, 1.0))
    return Trajectory(cell().robot.joint_names, times, HOME + p, v, a)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("lever", [0.01, 0.1])
def test_nothing_moves_farther_between_two_states_than_2_mm(seed: int, lever: float) -> None:
    """By the way of every joint, as it is seen at very many times, and what it moves per unit."""
    trajectory, reach = shaking(seed), lever * np.arange(1.0, N + 1)
    states = sample_states(cell().robot, trajectory, NONE, reach)
    t = np.unique(np.concatenate([np.linspace(0.0, 3.0, 20_000), states.times]))
    ways = np.abs(np.diff(trajectory.sample(t), axis=0))
    before = np.concatenate([np.zeros((1, N)), np.cumsum(ways, axis=0)])[np.searchsorted(t, states.times)]
    moved = np.diff(before @ reach)
    assert 0.3 * MAX_STEP < moved.max() <= states.max_step + 1e-12 <= MAX_STEP + 2e-12
    assert (np.diff(states.travel, axis=0) >= np.diff(before, axis=0) - 1e-9).all()
    assert states.travel[0].tolist() == [0.0] * N
    assert states.travel[-1] == pytest.approx(before[-1], rel=0.1)


def test_every_state_is_where_the_motion_is() -> None:
    trajectory = shaking(5)
    states = sample_states(cell().robot, trajectory, NONE, 0.02 * np.ones(N))
    assert pytest.approx(trajectory.sample(states.times), abs=1e-9) == states.Q
    assert states.links == pytest.approx(link_poses(cell().robot, states.Q), abs=1e-12)
    assert (np.diff(states.times) > 0.0).all()


def test_knots_and_asked_times_are_among_the_states_once() -> None:
    also = np.array([2.999, 0.4, 1e-4, 1.7 + 0.9e-9, 0.5 + 1.2e-9])
    trajectory = shaking(1)
    states = sample_states(cell().robot, trajectory, also, np.zeros(N))
    assert states.times.tolist() == [0.0, 1e-4, 0.4, 0.5, 0.5 + 1.2e-9, 1.7, 2.999, 3.0]


def at(*times: float) -> States:
    plan = rail(0.0)
    links: Array = np.empty((0, len(times), 4, 4))
    q = np.zeros((len(times), N))
    return States(np.array(times), q, links, q, 0.0, cell().robot, plan.trajectory)


def test_states_at_two_times_are_found_to_a_nanosecond() -> None:
    states = at(0.0, 1.0, 2.0, 3.0)
    for t_start, t_end, found in (
        (0.0, 3.0, (0, 3)), (1.0, 2.0, (1, 2)), (1.0 + 0.9e-9, 2.0 + 0.9e-9, (1, 2)),
        (1.0 - 0.9e-9, 2.0 - 0.9e-9, (1, 2)), (1.0 + 1.1e-9, 3.0 + 1.1e-9, (2, 3)), (2.0, 5.0, (2, 3)),
    ):  # fmt: skip
        assert states.between(t_start, t_end) == found


def test_a_stretch_is_cut_evenly_and_only_once() -> None:
    states = sample_states(cell().robot, shaking(2), NONE, np.zeros(N))
    finer = states.finer(2, 8)
    assert finer.times == pytest.approx(np.linspace(0.5, 1.7, 9))
    assert pytest.approx(shaking(2).sample(finer.times), abs=1e-9) == finer.Q
    assert states.finer(2, 8) is finer and states.finer(2, 4) is not finer


def test_what_would_take_too_many_states_is_told_by_how_far_it_moves(monkeypatch: pytest.MonkeyPatch) -> None:
    """A metre of the rail in 500 states, or in 499, which are too few."""
    reach = np.eye(N)[0]
    even = rail(1.0).trajectory
    even = replace(even, velocities=even.velocities + reach)  # at 1 m/s all the way
    for most, steps in ((500, MAX_STEP), (499, 1.0)):
        monkeypatch.setattr(state_sampling, "MAX_STATES", most)
        states = sample_states(cell().robot, even, NONE, reach)
        assert states.max_step == pytest.approx(steps)
        assert len(states.times) == (501 if most == 500 else 2)
    wild = sample_states(cell().robot, even, NONE, 1e300 * reach)
    assert len(wild.times) == 2 and wild.max_step == pytest.approx(1e300)
