"""Bounds of many pairs at once: never above a distance that the exact shapes have, and near to it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.shapes import Shape, ShapeKind, hull
from pickcli.geometry import Array, pose
from pickcli.motion.trajectory import Trajectory
from pickcli.verification.broad_phase import (
    Stretches,
    own_bounds,
    standing_near,
    state_intervals,
    tightened,
    world_bounds,
)
from pickcli.verification.fcl_solids import MAX_FCL_EXCESS, Solid
from pickcli.verification.held_pose import pose_in_tool
from pickcli.verification.moving_parts import Fixture, Part, parts_of_segments
from pickcli.verification.separation import half_width_terms, widest_gaps
from pickcli.verification.solid_arrays import SolidArrays
from pickcli.verification.state_sampling import States
from pickcli.verification.static_solids import plan_fixtures
from pickcli.verification.verify import sampled
from support.handmade_plans import cell, pick

ROUNDING = 1e-6  # m, to which fcl looks for the nearest points


def random_shape(rng: np.random.Generator) -> Shape:
    kind = ShapeKind(rng.choice(list(ShapeKind)))
    if kind is ShapeKind.HULL:
        return hull("hull", rng.uniform(0.01, 0.3, 3) * rng.normal(size=(20, 3)) / 2).shape
    n = {ShapeKind.BOX: 3, ShapeKind.CYLINDER: 2, ShapeKind.SPHERE: 1}[kind]
    return Shape(kind, tuple(rng.uniform(0.01, 0.3, n).tolist()))


def random_pose(rng: np.random.Generator) -> Array:
    return pose(rng.uniform(-0.4, 0.4, 3), rpy=rng.uniform(-np.pi, np.pi, 3))


def exact_distance(a: Shape, T_a: Array, b: Shape, T_b: Array) -> float:
    one, other = Solid(a), Solid(b)
    one.place(T_a)
    other.place(T_b)
    return one.distance(other)


@settings(max_examples=200, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_no_gap_is_wider_than_the_distance(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b, T_a, T_b = random_shape(rng), random_shape(rng), random_pose(rng), random_pose(rng)
    gap = widest_gaps(half_width_terms(a)[None], T_a[None], half_width_terms(b)[None], T_b[None])[0]
    # The search for the distance may fall short by as much.
    assert gap <= exact_distance(a, T_a, b, T_b) + MAX_FCL_EXCESS


@settings(max_examples=100, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_gap_of_two_boxes_tells_whether_they_meet(seed: int) -> None:
    """The axes that are tried are all that it takes (separating axis theorem)."""
    rng = np.random.default_rng(seed)
    a, b = (Shape(ShapeKind.BOX, tuple(rng.uniform(0.05, 0.3, 3).tolist())) for _ in range(2))
    T_a, T_b = random_pose(rng), random_pose(rng)
    gap = widest_gaps(half_width_terms(a)[None], T_a[None], half_width_terms(b)[None], T_b[None])[0]
    if abs(gap) > 1e-4:
        assert (gap > 0.0) == (exact_distance(a, T_a, b, T_b) > 0.0)


def test_faces_that_lie_opposite_each_other_are_bounded_exactly() -> None:
    terms = half_width_terms(Shape(ShapeKind.BOX, (0.2, 0.2, 0.2)))[None]
    assert widest_gaps(terms, np.eye(4)[None], terms, pose((0.25, 0.03, 0.0))[None])[0] == pytest.approx(0.05)


@cache
def carried() -> tuple[States, SolidArrays, list[int], list[int]]:
    """A pick's states, and what moves and what stands while it lifts the item; some of it with a slack."""
    plan, scene = pick()
    T_tip_item = pose_in_tool(plan, scene)
    moving = parts_of_segments(plan, scene, T_tip_item)
    k = next(k for k, segment in enumerate(plan.segments) if segment.held is not None)
    found: tuple[Part | Fixture, ...] = (*moving[k], *plan_fixtures(plan, scene, T_tip_item).of(k))
    solids = SolidArrays.of(replace(each, slack=0.01 * (i % 3)) for i, each in enumerate(found))
    n = len(moving[k])
    return sampled(plan, scene, moving), solids, list(range(n)), list(range(n, len(solids.solids)))


def distance_at(states: States, a: Part, b: Part | Fixture, i: int) -> float:
    for part in (a, b):
        if isinstance(part, Part):
            part.solid.place(states.links[part.link, i] @ part.T_link_shape)
    return a.solid.distance(b.solid) - a.slack - b.slack


def test_the_first_bounds_hold_all_over_their_windows() -> None:
    states, solids, moving, fixed = carried()
    cut = state_intervals(states, 0, len(states.times) - 1, solids.reach.max(axis=0))
    world = world_bounds(states, solids, np.array(moving), np.array(fixed), cut)
    own = own_bounds(states, solids, np.array(moving), cut)
    pairs = list(zip(*np.triu_indices(len(moving), 1), strict=True))
    rng = np.random.default_rng(0)
    for _ in range(300):
        w = int(rng.integers(len(cut.first)))
        i = int(rng.integers(cut.first[w], cut.last[w] + 1))
        p, f, q = int(rng.integers(len(moving))), int(rng.integers(len(fixed))), int(rng.integers(len(pairs)))
        a, b = solids.pair(moving[p], fixed[f])
        assert world[w, p, f] <= max(0.0, distance_at(states, a, b, i)) + ROUNDING
        a, b = solids.pair(moving[pairs[q][0]], moving[pairs[q][1]])
        assert own[w, q] <= max(0.0, distance_at(states, a, b, i)) + ROUNDING


@pytest.mark.parametrize("below", [0.0, 0.02, 0.05, 0.3, 2.0])
def test_what_is_left_out_of_the_first_bounds_is_farther_off(below: float) -> None:
    states, solids, moving, fixed = carried()
    cut = state_intervals(states, 0, len(states.times) - 1, solids.reach.max(axis=0))
    kept = standing_near(states, solids, np.array(moving), np.array(fixed), cut, below)
    world = world_bounds(states, solids, np.array(moving), np.array(fixed), cut).min(axis=(0, 1))
    assert set(kept) >= {f for f, bound in zip(fixed, world, strict=True) if bound < below - ROUNDING}
    assert below > 0.05 or len(kept) < len(fixed)


def test_tightened_bounds_hold_and_cover_the_same_motion() -> None:
    """All states of every pair remain in some stretch, and what stays low is too short to be split."""
    states, solids, moving, fixed = carried()
    a, b = (index.ravel() for index in np.meshgrid(moving, fixed, indexing="ij"))
    zero, last = np.zeros_like(a), np.full_like(a, len(states.times) - 1)
    whole = Stretches(np.full(len(a), -np.inf), zero, a, b, zero, last)
    below = 0.01
    found, reached = tightened(whole, below, below, states, solids)
    assert reached == below
    rng = np.random.default_rng(0)
    for k in rng.choice(len(found), 300).tolist():
        one, other = solids.pair(int(found.a[k]), int(found.b[k]))
        for i in {
            int(found.first[k]),
            int(found.last[k]),
            int(rng.integers(found.first[k], found.last[k] + 1)),
        }:
            assert found.bound[k] <= max(0.0, distance_at(states, one, other, i)) + ROUNDING
    for k in range(len(a)):
        mine = (found.a == a[k]) & (found.b == b[k])
        order = np.argsort(found.first[mine])
        first, end = found.first[mine][order], found.last[mine][order]
        assert first[0] == 0 and end[-1] == last[k] and (first[1:] == end[:-1]).all()
    assert (found.bound >= below).any()


@pytest.mark.parametrize(
    ("below", "floor", "reached"), [(0.05, 0.001, 0.02), (0.05, 0.03, 0.03), (0.01, 0.001, 0.01)]
)
def test_bounds_above_the_smallest_gap_are_no_use(below: float, floor: float, reached: float) -> None:
    """A cube at rest, 20 mm before a second one and 40 mm before a third: gaps are distances."""
    _, carrying, moving, _ = carried()
    part, shape = carrying.pair(moving[0], moving[0])[0], Shape(ShapeKind.BOX, (0.1, 0.1, 0.1))
    cube = replace(part, link=0, T_link_shape=np.eye(4), shape=shape, slack=0.0)
    others = [Fixture("cube", pose((x, 0.0, 0.0)), shape, Solid(shape)) for x in (0.12, 0.14)]
    solids, travel = SolidArrays.of((cube, *others)), np.zeros((9, cell().robot.n_joints))
    links = np.tile(np.eye(4), (1, 9, 1, 1))
    states = States(np.arange(9.0), travel, links, travel, 0.0, cell().robot, still())
    for order in ([1, 2], [2, 1]):
        zero = np.zeros(2, dtype=np.int64)
        whole = Stretches(np.full(2, -np.inf), zero, zero, np.array(order), zero, zero + 8)
        found, lowered = tightened(whole, below, floor, states, solids)
        assert lowered == pytest.approx(reached)
        assert dict(zip(found.b.tolist(), found.bound, strict=True)) == pytest.approx({1: 0.02, 2: 0.04})


@pytest.mark.parametrize("slack", [0.0, 0.02])
def test_a_ball_around_a_solid_holds_all_of_it_and_what_may_be_outside_of_it(slack: float) -> None:
    _, carrying, moving, _ = carried()
    part = carrying.pair(moving[0], moving[0])[0]
    for shape, radius in (
        (Shape(ShapeKind.BOX, (0.06, 0.08, 0.24)), 0.13),
        (Shape(ShapeKind.CYLINDER, (0.05, 0.24)), 0.13),
        (Shape(ShapeKind.SPHERE, (0.05,)), 0.05),
    ):
        solids = SolidArrays.of([replace(part, shape=shape, slack=slack)])
        np.testing.assert_allclose(solids.radii(np.zeros(2, dtype=np.int64)), radius + slack)


@pytest.mark.parametrize("n", [2, 3, 101, 2001])
@pytest.mark.parametrize("way", [1e-5, 1.9e-3])
@pytest.mark.parametrize("lever", [0.5, 1.0])
def test_a_segment_is_cut_where_its_fastest_part_has_moved_10_cm(n: int, way: float, lever: float) -> None:
    """All of its states, in as many intervals as its way has tenths of a metre."""
    first, last, lead = 7, 7 + n - 1, 3.0  # m moved before
    travel: Array = lead + way * np.arange(-7.0, n + 4)[:, None]
    times = np.arange(float(len(travel)))
    states = States(times, travel, np.zeros((1, len(times), 4, 4)), travel, way, cell().robot, still())
    cut = state_intervals(states, first, last, np.array([lever]))
    assert (cut.first[0], cut.last[-1]) == (first, last)
    assert (cut.first[1:] == cut.last[:-1]).all() and (cut.first < cut.last).all()
    assert (abs(cut.last + cut.first - 2 * cut.middle) <= 1).all()
    whole = lever * way * (n - 1)
    assert len(cut.first) == max(1, int(np.ceil(round(whole / 0.1, 9))))
    moved = lever * way * (cut.last - cut.first)
    assert moved.max() <= 0.1 + lever * way
    back, ahead = cut.middle - cut.first, cut.last - cut.middle
    expected = lever * way * np.maximum(back, ahead)
    np.testing.assert_allclose(cut.half_way(states, np.array([[lever]]))[:, 0], expected, atol=1e-12)


def test_a_segment_at_rest_is_one_interval() -> None:
    travel: Array = np.full((5, 1), 0.4)
    states = States(np.arange(5.0), travel, np.zeros((1, 5, 4, 4)), travel, 0.0, cell().robot, still())
    cut = state_intervals(states, 0, 4, np.ones(1))
    assert (cut.first.tolist(), cut.middle.tolist(), cut.last.tolist()) == ([0], [2], [4])


def still() -> Trajectory:
    """No motion: the intervals are cut by how far the states say that the joints travelled."""
    q = np.zeros((2, 1))
    return Trajectory(("joint",), np.array([0.0, 1.0]), q, q, q)


def test_two_solids_move_apart_by_the_joints_between_them_alone() -> None:
    """Two parts of which three joints move the one and two of these the other, and one that stands."""
    a, b = np.array([0.3, 0.02, 0.0]), np.array([0.5, 0.4, 0.1])
    _, carrying, _, _ = carried()
    solids = replace(carrying, link=np.array([1, 3, -1]), reach=np.stack([a, b, np.zeros(3)]))
    one, other = np.array([0, 1, 0, 2, 1, 0]), np.array([1, 0, 2, 0, 2, 0])
    expected = [[0.0, 0.0, 0.1], [0.0, 0.0, 0.1], a, a, b, [0.0, 0.0, 0.0]]
    np.testing.assert_array_equal(solids.relative_reach(one, other), expected)
