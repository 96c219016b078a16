"""Forward kinematics and Jacobian against the reference."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.kernel import Chain, Checker
from support.kernel_cases import random_arm, random_configuration, random_pose
from support.kernel_reference import frames

SEEDS = st.integers(0, 2**32 - 1)


@settings(deadline=None)
@given(SEEDS)
def test_frames_are_those_of_the_reference(seed: int) -> None:
    rng = np.random.default_rng(seed)
    arm = random_arm(rng)
    Q = np.array([random_configuration(rng, arm) for _ in range(3)])
    np.testing.assert_allclose(arm.chain().fk_batch(Q), frames(arm, Q), atol=1e-12)
    np.testing.assert_array_equal(arm.chain().fk(Q[0]), arm.chain().fk_batch(Q)[0])


@settings(deadline=None)
@given(SEEDS)
def test_jacobian_is_the_derivative_of_the_tip(seed: int) -> None:
    rng = np.random.default_rng(seed)
    arm = random_arm(rng)
    chain, q, T_last_tip = arm.chain(), random_configuration(rng, arm), random_pose(rng, 0.3)
    J = chain.jacobian(q, T_last_tip)
    h = 1e-6
    for j in range(arm.n):
        dq = np.eye(arm.n)[j] * h
        ahead, behind = chain.fk(q + dq)[-1] @ T_last_tip, chain.fk(q - dq)[-1] @ T_last_tip
        W = (ahead - behind)[:3, :3] @ (chain.fk(q)[-1] @ T_last_tip)[:3, :3].T / (2 * h)
        np.testing.assert_allclose(J[:3, j], (ahead - behind)[:3, 3] / (2 * h), atol=1e-7)
        np.testing.assert_allclose(J[3:, j], [W[2, 1], W[0, 2], W[1, 0]], atol=1e-7)


def test_axes_need_not_be_unit() -> None:
    def chain(length: float) -> Chain:
        return Chain(
            np.array([0, 1]), np.tile(np.eye(4), (2, 1, 1)), length * np.eye(3)[:2], np.array([1, 0])
        )

    q = np.array([0.3, -0.7])
    np.testing.assert_allclose(chain(5.0).fk(q), chain(1.0).fk(q), atol=1e-15)


def test_sixty_three_frames_and_thirty_two_joints() -> None:
    types = np.array([2 if k % 2 == 0 or k >= 63 else 0 for k in range(63)], np.int32)
    types[0] = 1
    q_index = np.full(63, -1, np.int32)
    q_index[types != 2] = np.arange(32)[::-1]
    T = np.tile(np.eye(4), (63, 1, 1))
    T[:, 0, 3] = 0.02
    chain = Chain(types, T, np.tile([0.0, 0.0, 1.0], (63, 1)), q_index)
    assert (chain.n, chain.n_frames) == (32, 63)
    frame, no_pairs = np.arange(63, dtype=np.int32), np.empty((0, 2), np.int32)
    checker = Checker(chain, np.zeros((63, 3)), np.full(63, 0.005), frame, no_pairs)
    ignored = np.array([~np.uint64(1 << 62)], np.uint64)  # only the last frame counts
    wall = np.eye(4)[None] * 1.0
    wall[0, :3, 3] = chain.fk(np.zeros(32))[-1][:3, 3]
    checker.set_world(wall, np.full((1, 3), 0.001), ignored)
    assert checker.clearance(np.zeros(32))[1:] == (62, 0, 0)
    assert not checker.is_free(np.zeros(32))
    assert checker.check_edge(np.zeros(32), np.ones(32)).frame == 62


@pytest.mark.parametrize(
    ("types", "q_index", "message"),
    [
        ([0, 2], [0, 1], "fixed joint must have q_index -1"),
        ([0, 0], [0, -1], "q_index of a moving joint"),
        ([0, 0], [0, 2], "no joint uses entry 1"),
        ([0, 3], [0, 1], "there is nothing else"),
        ([], [], "1..63 joints"),
    ],
)
def test_what_is_not_a_chain_is_refused(types: list[int], q_index: list[int], message: str) -> None:
    n = len(types)
    with pytest.raises(ValueError, match=message):
        Chain(np.array(types), np.tile(np.eye(4), (n, 1, 1)), np.ones((n, 3)), np.array(q_index))


def test_a_skewed_pose_is_refused() -> None:
    T = np.eye(4)[None].copy()
    T[0, 0, 0] = 1.1
    with pytest.raises(ValueError, match=r"T_parent_joint\[0\]: not a rigid pose"):
        Chain(np.array([0]), T, np.ones((1, 3)), np.array([0]))


@settings(max_examples=20, deadline=None)
@given(SEEDS)
def test_wrong_shapes_are_named(seed: int) -> None:
    arm = random_arm(np.random.default_rng(seed))
    with pytest.raises(ValueError, match=r"q: shape \(\d+\) instead of"):
        arm.chain().fk(np.zeros(arm.n + 1))
    with pytest.raises(ValueError, match="q: not finite"):
        arm.chain().fk(np.full(arm.n, np.nan))
