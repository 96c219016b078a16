"""Clouds are judged as the solids that they are, and so are worlds of thousands of solids."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.geometry import Array, pose
from pickcli.kernel import Checker, ContactKind
from support.kernel_cases import random_arm, random_configuration, random_edge, random_world
from support.kernel_reference import Arm, World, along, clearances, frames, spheres

SEEDS = st.integers(0, 2**32 - 1)
RESOLUTION = 2e-4


def cubes(centers: Array, radius: float, edge: float) -> World:
    """The cloud, as solids of the reference."""
    n = len(centers)
    T = np.tile(np.eye(4), (n, 1, 1))
    T[:, :3, 3] = centers
    none = np.zeros(n, np.uint64)
    return World(T, np.full((n, 3), edge / 2), none, np.zeros(n, np.int32), np.full(n, radius))


def both(a: World, b: World) -> World:
    """All solids of two worlds with kinds and roundings."""
    fields = ("T_world_box", "half_extents", "ignored_frames", "kind", "rounding")
    return World(*(np.concatenate([getattr(a, name), getattr(b, name)]) for name in fields))


def case(seed: int) -> tuple[np.random.Generator, Arm, World, Array, float, float]:
    """An arm, a world, and a cloud in clumps and alone, of points or of cubes."""
    rng = np.random.default_rng(seed)
    arm = random_arm(rng)
    clumps = rng.uniform(-1.2, 1.2, (int(rng.integers(1, 6)), 3))
    n = int(rng.choice([1, 7, 8, 9, 65, 200]))
    centers = clumps[rng.integers(len(clumps), size=n)] + rng.normal(scale=0.1, size=(n, 3))
    return rng, arm, random_world(rng, arm), centers, rng.choice([0.0, 0.004, 0.03]), rng.choice([0.0, 0.02])


@settings(max_examples=120, deadline=None)
@given(SEEDS)
def test_a_cloud_keeps_away_as_the_solids_that_it_is_made_of(seed: int) -> None:
    rng, arm, world, centers, radius, edge = case(seed)
    checker = arm.checker(world)
    checker.set_cloud(centers, radius, edge)
    everything = both(world, cubes(centers, radius, edge))
    q0, q1 = random_edge(rng, arm)
    lowest = float(clearances(arm, everything, along(q0, q1, 401)).min())
    assert checker.edge_is_free(q0, q1) <= (lowest > 0)
    if lowest > 2e-3:
        assert not checker.edge_is_free(q0, q1, lowest, resolution=RESOLUTION)
        assert checker.edge_is_free(q0, q1, lowest - 1.5e-3, resolution=RESOLUTION)
    Q = np.array([random_configuration(rng, arm) for _ in range(20)])
    exact = np.minimum(clearances(arm, everything, Q), 1.0)
    np.testing.assert_allclose(checker.clearances(Q), exact, atol=1e-6)
    assert not np.any(np.asarray(checker.are_free(Q)) & (exact <= 0))


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.sampled_from([0.01, 0.05, 0.3]))
def test_a_filtered_cloud_holds_all_its_points(seed: int, voxel: float) -> None:
    """It is never farther away than the points, and nearer by less than the diagonal of a cell."""
    rng, arm, world, centers, radius, edge = case(seed)
    empty = replace(world, **{name: getattr(world, name)[:0] for name in world.__dataclass_fields__})
    alone, filtered = arm.checker(empty), arm.checker(empty)
    alone.set_cloud(centers, radius, edge)
    filtered.set_cloud(centers, radius, edge, voxel)
    Q = np.array([random_configuration(rng, arm) for _ in range(40)])
    before, after = np.asarray(alone.clearances(Q)), np.asarray(filtered.clearances(Q))
    assert np.all(after <= before + 1e-6)
    assert np.all((after >= before - np.sqrt(3) * voxel - 1e-6) | (before < 0))


@settings(max_examples=40, deadline=None)
@given(SEEDS)
def test_where_the_frames_of_an_arm_meet_a_cloud_it_says_so(seed: int) -> None:
    rng, arm, _, _, _, _ = case(seed)
    q = random_configuration(rng, arm)
    centers, _, _ = spheres(arm, q[None])
    i = int(rng.integers(len(arm.radii)))
    far = np.array([[50.0, 0.0, 0.0], [0.0, 50.0, 0.0]])
    cloud = np.insert(far, int(rng.integers(3)), centers[0, i], axis=0)
    checker = Checker(arm.chain(), arm.centers, arm.radii, arm.frame, np.empty((0, 2), np.int32))
    checker.set_cloud(cloud, 0.001)
    report = checker.check_edge(q, q)
    nearest = int(np.argmin(np.linalg.norm(cloud - centers[0, i], axis=1)))
    assert (report.free, report.kind, report.index) == (False, ContactKind.CLOUD, nearest)
    assert checker.clearance(q)[2:] == (ContactKind.CLOUD, nearest)
    checker.set_cloud(cloud, 0.001, ignored_frames=2**64 - 1)
    assert checker.edge_is_free(q, q)
    checker.set_cloud(np.empty((0, 3)), 0.001)
    assert checker.edge_is_free(q, q) and checker.clearance(q)[1] == -1


@settings(max_examples=30, deadline=None)
@given(SEEDS, st.booleans())
def test_a_held_solid_keeps_away_from_a_cloud(seed: int, has_edge: bool) -> None:
    """A box that is held, among points: as the box of the reference from the points' balls."""
    rng, arm, _, centers, _, _ = case(seed)
    edge = 0.02 if has_edge else 0.0
    none = np.empty(0, np.int32)
    checker = Checker(arm.chain(), np.empty((0, 3)), np.empty(0), none, none.reshape(0, 2))
    checker.set_cloud(centers, 0.004, edge)
    half, T_last_solid = np.array([0.1, 0.05, 0.02]), pose([0.05, 0, 0.1], rpy=(0.3, 0.2, 0.1))
    checker.set_held_solid(T_last_solid, half, none)
    for _ in range(10):
        q = random_configuration(rng, arm)
        T = frames(arm, q[None])[0, -1] @ T_last_solid
        local = (centers - T[:3, 3]) @ T[:3, :3]
        gap = np.linalg.norm(np.maximum(np.abs(local) - half, 0.0), axis=1).min() - 0.004
        reach = np.sqrt(3) * edge / 2
        distance, _, kind, _ = checker.clearance(q, 5.0)
        if gap > reach:
            assert gap - reach - 1e-6 <= distance <= gap + 1e-6 and kind is ContactKind.CLOUD
            assert checker.is_free(q, 0.99 * (gap - reach) - 1e-4 if gap - reach > 2e-4 else 0.0)
        if gap <= 0:
            assert not checker.is_free(q)


@settings(max_examples=10, deadline=None)
@given(SEEDS)
def test_thousands_of_solids_are_judged_as_one_by_one(seed: int) -> None:
    rng, arm, _, _, _, _ = case(seed)
    n = int(rng.choice([500, 3000]))
    centers = rng.uniform(-1.5, 1.5, (n, 3))
    world = cubes(centers, 0.002, 0.03)
    checker = arm.checker(world)
    Q = np.array([random_configuration(rng, arm) for _ in range(10)])
    exact = clearances(arm, world, Q)
    np.testing.assert_allclose(checker.clearances(Q), np.minimum(exact, 1.0), atol=1e-9)
    free = np.asarray(checker.are_free(Q))
    assert np.all(free <= (exact > 0)) and np.all(free >= (exact > 1e-4))


@pytest.mark.parametrize(
    ("radius", "edge", "voxel", "named"),
    [
        (-0.1, 0.0, 0.0, "radius"),
        (np.nan, 0.0, 0.0, "radius"),
        (0.1, -0.1, 0.0, "edge"),
        (0.1, 0.0, -0.1, "voxel"),
        (0.1, 0.0, 1e-9, "voxel"),
    ],
)
def test_a_cloud_that_is_none_is_refused(radius: float, edge: float, voxel: float, named: str) -> None:
    arm = random_arm(np.random.default_rng(0))
    checker = arm.checker(random_world(np.random.default_rng(0), arm))
    with pytest.raises(ValueError, match=named):
        checker.set_cloud(np.ones((3, 3)), radius, edge, voxel)


def test_a_shared_cloud_is_that_of_the_other_checker_until_it_has_another() -> None:
    rng, arm, world, centers, radius, edge = case(7)
    one, other = arm.checker(world), arm.checker(world)
    Q = np.array([random_configuration(rng, arm) for _ in range(20)])
    before = np.asarray(other.clearances(Q))
    one.set_cloud(centers, radius, edge)
    expected = np.asarray(one.clearances(Q))
    assert np.any(expected < before)
    other.share_cloud(one)
    one.set_cloud(np.empty((0, 3)), radius)
    np.testing.assert_array_equal(other.clearances(Q), expected)
    np.testing.assert_array_equal(one.clearances(Q), before)
    other.share_cloud(other, ignored_frames=2**64 - 1)
    np.testing.assert_array_equal(other.clearances(Q), before)
