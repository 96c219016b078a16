"""Joint velocities that move the tip as wanted, and where they lead: against numpy and the tip itself."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.geometry import Array, pose, rotation_axis_angle, rotation_vector
from pickcli.kernel import Chain, TrackEnd
from support.kernel_cases import random_pose

SEEDS = st.integers(0, 2**32 - 1)
FREE = 1e3  # rad or m: no limit


def seven_joints(seed: int) -> tuple[Chain, Array, Array, Array]:
    """A chain of seven revolute joints, a configuration, the tip and limits of velocity."""
    rng = np.random.default_rng(seed)
    axes = np.array([[0, 0, 1], [0, 1, 0], [0, 0, 1], [0, 1, 0], [0, 0, 1], [0, 1, 0], [0, 0, 1.0]])
    T = np.array([pose([0.02, 0.0, z]) for z in (0.3, 0.1, 0.3, 0.1, 0.3, 0.1, 0.1)])
    chain = Chain(np.zeros(7, np.int32), T, axes, np.arange(7, dtype=np.int32))
    q = np.array([0.2, 0.5, -0.3, 1.7, 0.4, 0.9, -0.5]) + rng.uniform(-0.2, 0.2, 7)
    return chain, q, random_pose(rng, 0.1), rng.uniform(1.0, 4.0, 7)


def least(J: Array, twist: Array, velocity: Array) -> Array:
    """The velocities of least norm by their limits: J^+ of the scaled Jacobian."""
    return np.asarray(velocity * (np.linalg.pinv(J * velocity) @ twist))


@settings(deadline=None)
@given(SEEDS)
def test_rates_are_those_of_the_scaled_pseudo_inverse(seed: int) -> None:
    chain, q, T_last_tip, velocity = seven_joints(seed)
    rng = np.random.default_rng(seed)
    Q, own, twists = (
        q + rng.uniform(-0.1, 0.1, (3, 7)),
        rng.uniform(-1, 1, (3, 7)),
        rng.uniform(-1, 1, (3, 6)),
    )
    rates = chain.resolved_rates(Q, own, twists, T_last_tip, velocity)
    for q, given_, twist, rate in zip(Q, own, twists, rates, strict=True):
        J = chain.jacobian(q, T_last_tip)
        np.testing.assert_allclose(J @ rate, twist, atol=1e-9)
        np.testing.assert_allclose(rate, given_ + least(J, twist - J @ given_, velocity), atol=1e-7)


class Circle:
    """A motion of the tip on an arc while it turns, from where it is at the middle of the time."""

    def __init__(self, T_met: Array, n_times: int = 41) -> None:
        self.T_met, self.times, self.met = T_met, np.linspace(0.0, 1.0, n_times), n_times // 2

    def poses(self, t: Array) -> Array:
        """(N, 4, 4) at times (N,)."""
        found = np.repeat(self.T_met[None], len(t), axis=0)
        for T, s in zip(found, t - 0.5, strict=True):
            T[:3, 3] += (0.1 * np.sin(s), 0.1 * (1.0 - np.cos(s)), 0.05 * s)
            T[:3, :3] = rotation_axis_angle((0.0, 0.0, 1.0), 0.3 * s) @ T[:3, :3]
        return found

    def twists(self, t: Array) -> Array:
        """(N, 6) at times (N,)."""
        s, fixed = t - 0.5, np.ones(len(t))
        columns = 0.1 * np.cos(s), 0.1 * np.sin(s), 0.05 * fixed, 0.0 * s, 0.0 * s, 0.3 * fixed
        return np.column_stack(columns)


def tracked(
    given: tuple[Chain, Array, Array, Array], n_times: int = 41, lower: float = -FREE, fastest: float = 10.0
) -> tuple[Circle, Array, TrackEnd, int, int]:
    chain, q, T_last_tip, velocity = given
    wanted = Circle(chain.fk(q)[-1] @ T_last_tip, n_times)
    t = wanted.times
    middle, still = (t[1:] + t[:-1]) / 2.0, np.zeros((n_times, 7))
    answer = chain.track_tip(
        t, still, wanted.poses(t), wanted.twists(t), still[1:], wanted.twists(middle), wanted.met, q,
        T_last_tip, np.full(7, lower), np.full(7, FREE), velocity, fastest,
    )  # fmt: skip
    return wanted, *answer


@pytest.mark.parametrize("seed", range(8))
def test_the_tip_is_where_it_is_wanted_and_the_joints_are_where_fine_steps_of_numpy_lead(seed: int) -> None:
    given_ = chain, q, T_last_tip, velocity = seven_joints(seed)
    wanted, Q, end, _, _ = tracked(given_)
    assert end is TrackEnd.DONE and np.array_equal(Q[wanted.met], q)
    for T, row in zip(wanted.poses(wanted.times), Q, strict=True):
        tip = chain.fk(row)[-1] @ T_last_tip
        assert np.linalg.norm(tip[:3, 3] - T[:3, 3]) < 1e-7
        assert np.linalg.norm(rotation_vector(tip[:3, :3] @ T[:3, :3].T)) < 1e-7
    for end_row, t_end in ((Q[-1], 1.0), (Q[0], 0.0)):
        steps = np.linspace(0.5, t_end, 2001)
        x, h = q.copy(), steps[1] - steps[0]
        for t in (steps[1:] + steps[:-1]) / 2.0:  # the midpoint rule
            twist = wanted.twists(np.array([t]))[0]
            half = x + h / 2.0 * least(chain.jacobian(x, T_last_tip), twist, velocity)
            x = x + h * least(chain.jacobian(half, T_last_tip), twist, velocity)
        np.testing.assert_allclose(end_row, x, atol=2e-5)


def test_a_limit_ends_it_where_the_joint_passes_it() -> None:
    given_ = seven_joints(1)
    whole = tracked(given_)[1]
    after = whole[20:]
    joint = int(np.argmin(after[-1] - after[0]))
    lower = float(after[10, joint]) + 1e-4
    chain, q, T_last_tip, velocity = given_
    wanted = Circle(chain.fk(q)[-1] @ T_last_tip)
    t = wanted.times
    still, bounds = np.zeros((41, 7)), np.full(7, -FREE)
    bounds[joint] = lower
    _, end, at, which = chain.track_tip(
        t, still, wanted.poses(t), wanted.twists(t), still[1:], wanted.twists((t[1:] + t[:-1]) / 2.0), 20, q,
        T_last_tip, bounds, np.full(7, FREE), velocity, 10.0,
    )  # fmt: skip
    assert end is TrackEnd.LIMIT and which == joint and whole[at, joint] < lower <= whole[at - 1, joint]


def test_joints_that_would_be_too_fast_end_it_at_once() -> None:
    assert tracked(seven_joints(1), fastest=1e-3)[2] is TrackEnd.SINGULAR


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("times", np.zeros(41), "times: not increasing"),
        ("met", 41, "met: no index"),
        ("velocity", np.zeros(7), "not positive"),
        ("fastest", 0.0, "fastest: not positive"),
        ("own", np.zeros((40, 7)), "own: shape"),
    ],
)
def test_arguments_that_make_no_sense_are_refused_by_name(name: str, value: object, told: str) -> None:
    chain, q, T_last_tip, velocity = seven_joints(0)
    wanted = Circle(chain.fk(q)[-1] @ T_last_tip)
    t = wanted.times
    arguments: dict[str, Any] = {
        "times": t, "own": np.zeros((41, 7)), "T_world_tips": wanted.poses(t), "twists": wanted.twists(t),
        "own_between": np.zeros((40, 7)), "twists_between": wanted.twists(t[1:]), "met": 20, "q_met": q,
        "T_last_tip": T_last_tip, "lower": np.full(7, -FREE), "upper": np.full(7, FREE),
        "velocity": velocity, "fastest": 3.0,
    }  # fmt: skip
    with pytest.raises(ValueError, match=told):
        chain.track_tip(**{**arguments, name: value})
