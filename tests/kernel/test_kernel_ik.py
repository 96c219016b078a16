"""Inverse kinematics: solutions solve, stay within limits, and follow without jumps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.geometry import Array, pose, rotation_angle, rotation_axis_angle
from pickcli.kernel import Chain

SEEDS = st.integers(0, 2**32 - 1)
# Motoman SIA20F on a rail, as in the default cell, with a lance of 0.54 m.
ORIGINS = [
    (-1.758, 0, 0.85),
    (0, 0, 0.41),
    (0, 0, 0),
    (0, 0, 0.49),
    (0, 0, 0),
    (0, 0, 0.42),
    (0, 0, 0),
    (0, 0, 0.18),
]
AXES = [(1, 0, 0), (0, 0, 1), (0, 1, 0), (0, 0, 1), (0, -1, 0), (0, 0, -1), (0, -1, 0), (0, 0, -1)]
UPPER = np.array([1.15, 3.1415, 1.9198, 2.967, 2.2689, 3.1415, 1.9198, 3.1415])
LOWER = np.concatenate([[0.05], -UPPER[1:]])
CHAIN = Chain(
    np.array([1] + [0] * 7),
    np.stack([pose(o) for o in ORIGINS]),
    np.array(AXES),
    np.arange(8, dtype=np.int32),
)
LANCE = pose([0, 0, 0.54])
HOME = np.array([0.158, 0, -0.30, 0, -1.90, 0, 0.03, 0])
ONES = np.ones(8)


def tip(q: Array) -> Array:
    return np.asarray(CHAIN.fk(q)[-1] @ LANCE)


def assert_same_pose(T: Array, expected: Array, position: float = 1e-5, rotation: float = 1e-4) -> None:
    assert np.linalg.norm(T[:3, 3] - expected[:3, 3]) <= position + 1e-12
    assert rotation_angle(T[:3, :3].T @ expected[:3, :3]) <= rotation + 1e-9


@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_solutions_reach_the_target_within_limits_and_differ(seed: int) -> None:
    rng = np.random.default_rng(seed)
    target = tip(rng.uniform(LOWER, UPPER))
    seeds = rng.uniform(LOWER, UPPER, (20, 8))
    solutions = CHAIN.ik(target, LANCE, seeds, LOWER, UPPER, ONES)
    assert len(solutions) > 0
    for i, q in enumerate(solutions):
        assert_same_pose(tip(q), target)
        assert np.all((q >= LOWER) & (q <= UPPER))
        assert all(np.abs(q - other).max() > 0.05 for other in solutions[:i])
    np.testing.assert_array_equal(solutions, CHAIN.ik(target, LANCE, seeds, LOWER, UPPER, ONES))


def test_most_seeds_succeed() -> None:
    rng = np.random.default_rng(0)
    targets = [tip(rng.uniform(LOWER, UPPER)) for _ in range(200)]
    n = sum(len(CHAIN.ik(T, LANCE, rng.uniform(LOWER, UPPER, (1, 8)), LOWER, UPPER, ONES)) for T in targets)
    assert n > 120


def test_a_seed_that_solves_is_returned_as_it_is() -> None:
    np.testing.assert_array_equal(CHAIN.ik(tip(HOME), LANCE, HOME[None], LOWER, UPPER, ONES), HOME[None])


def test_out_of_reach_gives_no_solution() -> None:
    rng = np.random.default_rng(0)
    far = pose([5.0, 0, 1])
    assert CHAIN.ik(far, LANCE, rng.uniform(LOWER, UPPER, (5, 8)), LOWER, UPPER, ONES).shape == (0, 8)


def test_a_heavy_joint_moves_less() -> None:
    target = tip(HOME) @ pose([0, 0, 0.1])
    weights = ONES.copy()
    light = CHAIN.ik(target, LANCE, HOME[None], LOWER, UPPER, weights)[0]
    weights[0] = 1000.0
    heavy = CHAIN.ik(target, LANCE, HOME[None], LOWER, UPPER, weights)[0]
    assert abs(heavy[0] - HOME[0]) < 0.1 * abs(light[0] - HOME[0])


@settings(deadline=None)
@given(st.floats(0.0, np.pi), st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda a: np.linalg.norm(a) > 0.1))
def test_any_turn_up_to_a_half_one_is_found(angle: float, axis: tuple[float, float, float]) -> None:
    """The rotation error is well-behaved at both ends of its range."""
    R = rotation_axis_angle(np.array(axis) / np.linalg.norm(axis), angle)
    ball = Chain(
        np.zeros(3, np.int32), np.tile(np.eye(4), (3, 1, 1)), np.eye(3), np.arange(3, dtype=np.int32)
    )
    limit = np.full(3, 10.0)
    seeds = np.random.default_rng(0).uniform(-3, 3, (10, 3))
    found = ball.ik(pose(R=R), np.eye(4), seeds, -limit, limit, np.ones(3))
    assert len(found) > 0
    for q in found:
        assert_same_pose(ball.fk(q)[-1], pose(R=R))


LOOSE = 0.1, 1.0  # m and rad off the line


def test_a_straight_line_is_followed_in_small_steps() -> None:
    line = np.stack([tip(HOME) @ pose([0, 0, 0.005 * i]) for i in range(1, 80)])
    Q, reason, _ = CHAIN.follow(line, LANCE, HOME, LOWER, UPPER, ONES, np.full(8, 0.05), *LOOSE)
    assert reason == 0
    assert np.abs(np.diff(np.vstack([HOME, Q]), axis=0)).max() <= 0.05
    for q, target in zip(Q, line, strict=True):
        assert_same_pose(tip(q), target)


def test_following_tells_why_it_ends() -> None:
    line = np.stack([tip(HOME) @ pose([0, 0, 0.01 * i]) for i in range(200)])
    Q, reason, _ = CHAIN.follow(line, LANCE, HOME, LOWER, UPPER, ONES, np.full(8, 0.2), *LOOSE)
    assert 0 < len(Q) < 200
    assert reason in (1, 2, 3)  # somewhere before 2 m the arm is stretched or a limit is met
    Q, reason, _ = CHAIN.follow(line[:5], LANCE, HOME, LOWER, UPPER, ONES, np.full(8, 1e-6), *LOOSE)
    assert (len(Q), reason) == (1, 2)
    lower, upper = HOME - 1e-3, HOME + 1e-3
    Q, reason, _ = CHAIN.follow(line[:5], LANCE, HOME, lower, upper, ONES, np.full(8, 0.2), *LOOSE)
    assert (len(Q), reason) == (1, 3)


def test_bad_limits_and_weights_are_refused() -> None:
    with pytest.raises(ValueError, match=r"lower\[0\] is above upper"):
        CHAIN.ik(tip(HOME), LANCE, HOME[None], UPPER, LOWER, ONES)
    with pytest.raises(ValueError, match=r"weights\[0\] is not positive"):
        CHAIN.ik(tip(HOME), LANCE, HOME[None], LOWER, UPPER, 0 * ONES)
    with pytest.raises(ValueError, match=r"seeds: shape \(8\) instead of \(any, 8\)"):
        CHAIN.ik(tip(HOME), LANCE, HOME, LOWER, UPPER, ONES)
