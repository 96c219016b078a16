"""Clearance and free configurations against the reference."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from support.kernel_cases import random_arm, random_configuration, random_world
from support.kernel_reference import clearances, pair_clearances

SEEDS = st.integers(0, 2**32 - 1)


@settings(deadline=None)
@given(SEEDS)
def test_clearance_is_that_of_the_reference(seed: int) -> None:
    rng = np.random.default_rng(seed)
    arm = random_arm(rng)
    world = random_world(rng, arm)
    checker = arm.checker(world)
    Q = np.array([random_configuration(rng, arm) for _ in range(10)])
    pairs = pair_clearances(arm, world, Q)
    expected = np.minimum(clearances(arm, world, Q), 0.5)
    np.testing.assert_allclose(checker.clearances(Q, 0.5), expected, atol=1e-12)
    for i, q in enumerate(Q):
        distance, *pair = checker.clearance(q, 0.5)
        if distance == 0.5:
            assert pair == [-1, -1, -1]
        else:
            assert abs(pairs[pair[0], pair[1], pair[2]][i] - distance) < 1e-12


@settings(deadline=None)
@given(SEEDS, st.booleans())
def test_the_clearest_are_those_with_the_largest_clearances(seed: int, holds_solid: bool) -> None:
    rng = np.random.default_rng(seed)
    arm = random_arm(rng)
    checker = arm.checker(random_world(rng, arm))
    if holds_solid:
        extents, kind = rng.uniform(0.02, 0.2, 3), int(rng.integers(3))
        half = {0: extents, 1: extents[[0, 0, 2]], 2: extents[[0, 0, 0]]}[kind]
        checker.set_held_solid(np.eye(4), half, np.zeros(0, np.int32), kind, 0.004)
    Q = np.array([random_configuration(rng, arm) for _ in range(20)])
    Q[5] = Q[3]  # of two that are equally clear the first counts
    distances = checker.clearances(Q, 0.5)
    for n_most in (0, 1, 4, 20, 25):
        rows, found = checker.clearest(Q, n_most, 0.5)
        expected = np.argsort(-distances, kind="stable")[:n_most]
        np.testing.assert_array_equal(rows, expected)
        np.testing.assert_array_equal(found, distances[expected])


@settings(deadline=None)
@given(SEEDS)
def test_free_configurations_agree_but_for_rounding(seed: int) -> None:
    """Single precision may only err towards not free, and by no more than the stated rounding."""
    rng = np.random.default_rng(seed)
    arm = random_arm(rng)
    world = random_world(rng, arm)
    checker = arm.checker(world)
    for q in [random_configuration(rng, arm) for _ in range(5)]:
        clearance = float(clearances(arm, world, q[None])[0])
        if 1e-3 < clearance < np.inf:
            assert not checker.is_free(q, clearance)
            assert checker.is_free(q, clearance - 2 * checker.rounding)
        assert checker.is_free(q) == (clearance > 0) or abs(clearance) < 2 * checker.rounding


@settings(deadline=None)
@given(SEEDS)
def test_many_are_free_where_each_is(seed: int) -> None:
    rng = np.random.default_rng(seed)
    arm = random_arm(rng)
    checker = arm.checker(random_world(rng, arm))
    Q = np.array([random_configuration(rng, arm) for _ in range(int(rng.integers(1, 20)))])
    assert checker.are_free(Q, 0.01).tolist() == [checker.is_free(q, 0.01) for q in Q]


def test_rounding_is_far_below_any_clearance_that_matters() -> None:
    rng = np.random.default_rng(0)
    arm = random_arm(rng)
    assert 0 < arm.checker(random_world(rng, arm)).rounding < 2e-4


def test_a_held_item_is_tested_cleared_and_ignored() -> None:
    rng = np.random.default_rng(1)
    arm = random_arm(rng)
    q = random_configuration(rng, arm)
    tip = arm.chain().fk(q)[-1]
    checker = arm.checker(random_world(np.random.default_rng(2), arm))
    half = np.full((1, 3), 0.01)
    everyone_else = np.array([~np.uint64(1 << arm.n_frames)], np.uint64)
    nobody = np.array([~np.uint64(0)], np.uint64)
    nothing = np.empty(0, np.int32)

    checker.set_world(tip[None], half, everyone_else)
    checker.set_held(np.zeros((1, 3)), np.array([0.02]), nothing)
    assert checker.clearance(q)[1:] == (arm.n_frames, 0, 0)
    checker.set_world(tip[None], half, nobody)
    assert checker.clearance(q)[0] > -0.02 or checker.clearance(q)[1] != arm.n_frames
    checker.set_world(tip[None], half, everyone_else)
    checker.set_held(np.empty((0, 3)), np.empty(0), nothing)
    assert checker.clearance(q)[1] != arm.n_frames
