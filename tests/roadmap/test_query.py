"""Coarse queries: who answers, what is dropped, what is promised of the answer."""

from __future__ import annotations

import numpy as np
import pytest
from box_world import BoxWorld, space, wall
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.errors import NoPlanError
from pickcli.roadmap.connect import QueryOptions
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.planners import PlannerName
from pickcli.roadmap.query import CoarseRoute, How, query

START, GOAL = np.array([-0.8, -0.5]), np.array([0.8, -0.5])


def test_a_free_straight_line_needs_no_roadmap() -> None:
    route = query(_roadmap(), BoxWorld(), space(), START, GOAL[None], seed=1)
    assert route.how is How.STRAIGHT and route.new == ()
    np.testing.assert_array_equal(route.path.waypoints, [START, GOAL])


def test_the_roadmap_leads_through_the_gap() -> None:
    route = query(_roadmap(), wall(), space(), START, GOAL[None], seed=1, options=_roadmap_only())
    assert route.how is How.ROADMAP
    assert route.nodes == ("left", "right")
    _check(route, wall(), START, GOAL)


def test_a_stored_edge_that_is_blocked_now_is_dropped_and_the_search_goes_on() -> None:
    world = wall()
    world.boxes.append(
        (np.array([-0.3, 0.88]), np.array([0.3, 0.92]))
    )  # on the stored way, leaves room above
    route = query(_roadmap(), world, space(), START, GOAL[None], seed=1)
    assert route.how is How.PLANNER
    _check(route, world, START, GOAL)
    both = query(_two_ways(), world, space(), START, GOAL[None], seed=1, options=_roadmap_only())
    assert both.how is How.ROADMAP
    assert both.dropped == (("left", "right"),)
    _check(both, world, START, GOAL)


def test_without_a_roadmap_the_planner_answers() -> None:
    empty = Roadmap.empty(space().joint_names)
    route = query(empty, wall(), space(), START, GOAL[None], seed=1)
    assert route.how is How.PLANNER
    _check(route, wall(), START, GOAL)


@pytest.mark.parametrize("planner", [PlannerName.RRT_CONNECT, PlannerName.RRT_STAR])
def test_ends_without_a_straight_link_are_linked_by_the_planner(planner: PlannerName) -> None:
    # Each end sits in a pocket that no node can be seen from.
    pocket = [
        (np.array([-0.95, -0.35]), np.array([-0.65, -0.3])),
        (np.array([-0.65, -0.7]), np.array([-0.6, -0.3])),
        (np.array([0.65, -0.35]), np.array([0.95, -0.3])),
        (np.array([0.6, -0.7]), np.array([0.65, -0.3])),
    ]
    world = BoxWorld(wall().boxes + pocket)
    options = QueryOptions(planner=planner, n_rivals=0, max_iterations=2000)
    route = query(_roadmap(), world, space(), START, GOAL[None], seed=4, options=options)
    assert route.how is How.ROADMAP
    _check(route, world, START, GOAL)


def test_a_detour_over_the_roadmap_meets_a_rival() -> None:
    roadmap = Roadmap.empty(space().joint_names)
    far = np.array([[-0.9, 0.9], [-0.9, 0.99], [0.9, 0.99], [0.9, 0.9]])
    roadmap, a = roadmap.with_node(far[0])
    roadmap, b = roadmap.with_node(far[-1])
    roadmap = roadmap.with_edge(a, b, far)
    block = BoxWorld([(np.array([-0.05, -0.6]), np.array([0.05, -0.4]))])  # small, easily passed
    route = query(roadmap, block, space(), START, GOAL[None], seed=1)
    _check(route, block, START, GOAL)
    assert route.path.length < 2.0


def test_of_several_goals_one_that_is_free_is_reached_and_named() -> None:
    goals = np.array([[0.0, 0.0], [0.9, 0.0], [5.0, 0.0], [0.8, -0.5]])
    route = query(_roadmap(), wall(), space(), START, goals, seed=1)
    assert route.goal in (1, 3)
    np.testing.assert_array_equal(route.path.end, goals[route.goal])


def test_the_links_of_start_and_goal_are_handed_out_and_nothing_that_is_stored() -> None:
    route = query(_roadmap(), wall(), space(), START, GOAL[None], seed=1, options=_roadmap_only())
    ends = sorted(tuple(polyline[0]) for polyline in route.new)
    assert ends == sorted([tuple(START), tuple(GOAL)])
    nodes = {tuple(q) for q in _roadmap().configurations}
    assert all(tuple(polyline[-1]) in nodes for polyline in route.new)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**31))
def test_same_query_same_bytes(seed: int) -> None:
    def once() -> bytes:
        return query(_roadmap(), wall(), space(), START, GOAL[None], seed=seed).path.waypoints.tobytes()

    assert once() == once()


def test_every_reason_is_told() -> None:
    with pytest.raises(NoPlanError, match=r"start: collision: inside a box"):
        query(_roadmap(), wall(), space(), np.zeros(2), GOAL[None], seed=1)
    with pytest.raises(NoPlanError, match="joint limit") as caught:
        query(_roadmap(), wall(), space(), START, np.array([[0.0, 0.0], [1.5, 0.0]]), seed=1)
    assert [reason.what for reason in caught.value.reasons] == ["collision", "joint limit"]
    assert "j0 at 1.5000 is 0.5 outside" in caught.value.reasons[1].detail
    with pytest.raises(NoPlanError, match="no path"):
        options = QueryOptions(max_iterations=200)
        query(_roadmap(), wall(gap=-0.1), space(), START, GOAL[None], seed=1, options=options)


def _check(route: CoarseRoute, world: BoxWorld, start: np.ndarray, goal: np.ndarray) -> None:
    np.testing.assert_array_equal(route.path.waypoints[[0, -1]], [start, goal])
    assert world.path_is_free(route.path.waypoints) == -1


def _roadmap_only() -> QueryOptions:
    """The roadmap's answer whatever it costs."""
    return QueryOptions(n_rivals=0)


def _roadmap() -> Roadmap:
    """Two nodes on either side of the wall, joined through its gap."""
    roadmap = Roadmap.empty(space().joint_names)
    roadmap, a = roadmap.with_node(np.array([-0.5, 0.9]), "left")
    roadmap, b = roadmap.with_node(np.array([0.5, 0.9]), "right")
    return roadmap.with_edge(a, b, np.array([[-0.5, 0.9], [0.5, 0.9]]))


def _two_ways() -> Roadmap:
    """The same with a longer edge above."""
    return _roadmap().with_edge(0, 1, np.array([[-0.5, 0.9], [0.0, 0.97], [0.5, 0.9]]) * [1, 1])
