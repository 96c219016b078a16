"""Shortening and costs."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.motion.path import JointPath
from pickcli.path_planning.path_cost import estimated_duration
from pickcli.path_planning.sampling_planner import plan
from pickcli.path_planning.shortcutting import shorten
from support.box_world import BoxWorld, space, wall
from support.edge_costs import edge_costs


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**31), n=st.integers(2, 3))
def test_shorter_with_the_same_ends_and_still_proven(seed: int, n: int) -> None:
    world, joints = _clutter(seed, n), space(n)
    start, goal = np.full(n, -0.95), np.full(n, 0.95)
    path = plan(world, joints, start, goal[None], seed=seed + 1)
    if path is None:
        return
    short = shorten(world, joints, path, seed=seed)
    np.testing.assert_array_equal(short.waypoints[[0, -1]], [start, goal])
    assert world.is_valid_path(short.waypoints)
    before, after = edge_costs(joints, path.waypoints).sum(), edge_costs(joints, short.waypoints).sum()
    assert after <= before + 1e-12
    assert shorten(world, joints, path, seed=seed).waypoints.tobytes() == short.waypoints.tobytes()


def test_a_detour_in_free_space_becomes_the_straight_edge() -> None:
    detour = JointPath(("j0", "j1"), np.array([[0.0, 0.0], [0.5, 0.9], [-0.5, 0.3], [0.2, 0.0]]))
    short = shorten(BoxWorld(), space(), detour, seed=0)
    np.testing.assert_array_equal(short.waypoints, detour.waypoints[[0, -1]])


def test_random_shortcuts_beat_the_removal_of_vertices() -> None:
    tall = JointPath(("j0", "j1"), np.array([[-0.8, -0.8], [-0.06, 1.0], [0.06, 1.0], [0.8, -0.8]]))
    world = wall()
    without = shorten(world, space(), tall, seed=1, iterations=0)
    with_shortcuts = shorten(world, space(), tall, seed=1, iterations=200)
    cost = [edge_costs(space(), p.waypoints).sum() for p in (without, with_shortcuts)]
    assert cost[1] < 0.98 * cost[0]


def test_duration_of_one_edge_is_the_trapezoid() -> None:
    # 2 rad at 1 rad/s and 2 rad/s^2: 0.5 s up, 0.5 s down, 1.5 s between.
    assert estimated_duration(space(), np.array([[-1.0, 0.0], [1.0, 0.0]])) == pytest.approx(2.5)
    # 0.2 rad: a triangle.
    assert estimated_duration(space(), np.array([[0.0, 0.0], [0.2, 0.0]])) == pytest.approx(2 * np.sqrt(0.1))


def test_duration_knows_what_corners_cost() -> None:
    straight = np.array([[-1.0, 0.0], [0.0, 0.0], [1.0, 0.0]])
    bent = np.array([[-1.0, -1.0], [0.0, 0.0], [-1.0, 1.0]])  # j0 turns round, j1 goes on
    assert estimated_duration(space(), straight) == pytest.approx(2.5)
    assert estimated_duration(space(), bent) > 2.5 + 0.2
    assert estimated_duration(space(), bent) < 2 * 1.5 + 1e-9  # no worse than a full stop


def test_duration_ignores_repeated_points() -> None:
    Q = np.array([[-1.0, 0.0], [-1.0, 0.0], [1.0, 0.0], [1.0, 0.0]])
    assert estimated_duration(space(), Q) == pytest.approx(2.5)
    assert estimated_duration(space(), Q[:2]) == 0.0


def _clutter(seed: int, n: int) -> BoxWorld:
    rng = np.random.default_rng(seed)
    centres, halves = rng.uniform(-0.7, 0.7, (6, n)), rng.uniform(0.05, 0.4, (6, n))
    ends = [np.full(n, -0.95), np.full(n, 0.95)]
    boxes = [(c - h, c + h) for c, h in zip(centres, halves, strict=True)]
    return BoxWorld([b for b in boxes if all(BoxWorld([b]).is_valid(end) for end in ends)], n)
