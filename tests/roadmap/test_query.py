"""Coarse queries: who answers, what is dropped, what is promised of the answer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.errors import NoPlanError
from pickcli.motion.path import JointPath
from pickcli.path_planning.path_cost import estimated_duration
from pickcli.path_planning.planner_names import PlannerName
from pickcli.path_planning.shortcutting import shorten
from pickcli.roadmap.connection import PlanningProblem, QueryOptions
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.query import CoarseRoute, RouteSource, query
from pickcli.seeds import derived_seed
from support.box_world import BoxWorld, space, wall

START, GOAL = np.array([-0.8, -0.5]), np.array([0.8, -0.5])
LINE = JointPath(space().joint_names, np.stack([START, GOAL]))
SCREEN = BoxWorld([(np.array([-0.05, -0.9]), np.array([0.05, 0.9]))])  # quickly passed below, slowly above


def test_a_free_straight_line_needs_no_roadmap() -> None:
    route = query(PlanningProblem(_roadmap(), BoxWorld(), space(), START, GOAL[None], seed=1))
    assert route.source is RouteSource.STRAIGHT and route.new == ()
    np.testing.assert_array_equal(route.path.waypoints, [START, GOAL])


def test_the_roadmap_leads_through_the_gap() -> None:
    route = query(
        PlanningProblem(_roadmap(), wall(), space(), START, GOAL[None], seed=1, options=_roadmap_only())
    )
    assert route.source is RouteSource.ROADMAP
    assert route.nodes == ("left", "right")
    _check(route, wall(), START, GOAL)


def test_a_stored_edge_that_is_blocked_now_is_dropped_and_the_search_goes_on() -> None:
    world = wall()
    world.boxes.append(
        (np.array([-0.3, 0.88]), np.array([0.3, 0.92]))
    )  # on the stored way, leaves room above
    route = query(PlanningProblem(_roadmap(), world, space(), START, GOAL[None], seed=1))
    assert route.source is RouteSource.PLANNER
    _check(route, world, START, GOAL)
    both = query(
        PlanningProblem(_two_ways(), world, space(), START, GOAL[None], seed=1, options=_roadmap_only())
    )
    assert both.source is RouteSource.ROADMAP
    assert both.dropped == (("left", "right"),)
    _check(both, world, START, GOAL)


def test_without_a_roadmap_the_planner_answers() -> None:
    empty = Roadmap.empty(space().joint_names)
    route = query(PlanningProblem(empty, wall(), space(), START, GOAL[None], seed=1))
    assert route.source is RouteSource.PLANNER
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
    options = QueryOptions(planner=planner, n_competing_plans=0, max_iterations=2000)
    route = query(PlanningProblem(_roadmap(), world, space(), START, GOAL[None], seed=4, options=options))
    assert route.source is RouteSource.ROADMAP
    _check(route, world, START, GOAL)


def test_a_detour_over_the_roadmap_loses_to_a_rival() -> None:
    stored = query(
        PlanningProblem(_over(), SCREEN, space(), START, GOAL[None], seed=0, options=_roadmap_only())
    )
    route = query(PlanningProblem(_over(), SCREEN, space(), START, GOAL[None], seed=0))
    assert (stored.source, route.source) == (RouteSource.ROADMAP, RouteSource.PLANNER)
    assert _seconds(route.path) < 0.7 * _seconds(stored.path)
    _check(route, SCREEN, START, GOAL)


@pytest.mark.parametrize("seed", range(4))
def test_the_quickest_of_the_roadmap_and_all_rivals_wins(seed: int) -> None:
    options = QueryOptions(enough=0.0, n_competing_plans=4)
    route = query(PlanningProblem(_over(), SCREEN, space(), START, GOAL[None], seed=seed, options=options))
    assert _seconds(route.path) == min(_each_alone(seed, options))


@pytest.mark.parametrize(("enough", "answer"), [(np.inf, 0), (1.1, 2), (1.0, 3)])
def test_the_search_ends_with_what_is_quick_enough(enough: float, answer: int) -> None:
    """The roadmap's answer, one rival that is not the quickest, all of them."""
    options = QueryOptions(enough=enough, n_competing_plans=6)
    alone = _each_alone(4, options)
    assert min(alone) == alone[3] < alone[2] <= 1.1 * _seconds(LINE) < min(alone[:2])
    route = query(PlanningProblem(_over(), SCREEN, space(), START, GOAL[None], seed=4, options=options))
    assert _seconds(route.path) == alone[answer]


def test_of_several_goals_one_that_is_free_is_reached_and_named() -> None:
    goals = np.array([[0.0, 0.0], [0.9, 0.0], [5.0, 0.0], [0.8, -0.5]])
    route = query(PlanningProblem(_roadmap(), wall(), space(), START, goals, seed=1))
    assert route.goal in (1, 3)
    np.testing.assert_array_equal(route.path.end, goals[route.goal])


@settings(max_examples=50, deadline=None)
@given(costs=st.lists(st.floats(0.0, 3.0), min_size=4, max_size=4), seed=st.integers(0, 100))
def test_no_straight_edge_is_better_than_the_motion_with_the_rest_after_it(
    costs: list[float], seed: int
) -> None:
    goals = np.array([[-0.5, 0.2], GOAL, [-0.9, 0.7], [0.5, 0.9]])
    posed = PlanningProblem(_roadmap(), wall(), space(), START, goals, seed, QueryOptions(), np.array(costs))
    route = query(posed)
    np.testing.assert_array_equal(route.path.end, goals[route.goal])
    straight = [
        estimated_duration(space(), np.stack([START, goal])) + cost
        for goal, cost in zip(goals, costs, strict=True)
        if wall().is_valid_edge(START, goal)
    ]
    assert len(straight) == 2
    assert route.duration + costs[route.goal] <= min(straight)


def test_a_dear_rest_sends_the_search_to_a_goal_that_is_farther() -> None:
    goals = np.array([[-0.5, 0.2], GOAL])
    posed = PlanningProblem(_roadmap(), wall(), space(), START, goals, 1, costs_to_go=np.array([60.0, 0.0]))
    assert query(posed).goal == 1 and query(posed).source is not RouteSource.STRAIGHT
    assert query(replace(posed, costs_to_go=np.array([0.0, 0.0]))).goal == 0


def test_a_precomputed_path_is_proven_again_and_competes_with_straight_edges() -> None:
    over = np.array([START, [-0.8, 0.9], [0.8, 0.9], GOAL])
    posed = PlanningProblem(_roadmap(), wall(), space(), START, GOAL[None], 1, precomputed=(over,))
    route = query(posed)
    assert (route.source, route.new) == (RouteSource.DATABASE, ())
    np.testing.assert_array_equal(route.path.waypoints, over)
    through = replace(posed, precomputed=(np.array([START, [0.0, -0.4], GOAL]),))
    assert query(through).source in (RouteSource.ROADMAP, RouteSource.PLANNER)
    near = replace(posed, goals=np.array([GOAL, [-0.5, 0.2]]), costs_to_go=np.array([0.0, 0.5]))
    assert query(near).source is RouteSource.STRAIGHT


def test_the_links_of_start_and_goal_are_handed_out_and_nothing_that_is_stored() -> None:
    route = query(
        PlanningProblem(_roadmap(), wall(), space(), START, GOAL[None], seed=1, options=_roadmap_only())
    )
    ends = sorted(tuple(polyline[0]) for polyline in route.new)
    assert ends == sorted([tuple(START), tuple(GOAL)])
    nodes = {tuple(q) for q in _roadmap().configurations}
    assert all(tuple(polyline[-1]) in nodes for polyline in route.new)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**31))
def test_same_query_same_bytes(seed: int) -> None:
    def once() -> bytes:
        return query(
            PlanningProblem(_roadmap(), wall(), space(), START, GOAL[None], seed=seed)
        ).path.waypoints.tobytes()

    assert once() == once()


def test_every_reason_is_told() -> None:
    with pytest.raises(NoPlanError, match=r"start: collision: inside a box"):
        query(PlanningProblem(_roadmap(), wall(), space(), np.zeros(2), GOAL[None], seed=1))
    with pytest.raises(NoPlanError, match="joint limit") as caught:
        query(PlanningProblem(_roadmap(), wall(), space(), START, np.array([[0.0, 0.0], [1.5, 0.0]]), seed=1))
    assert [reason.what for reason in caught.value.reasons] == ["collision", "joint limit"]
    assert "j0 at 1.5000 is 0.5 outside" in caught.value.reasons[1].detail
    with pytest.raises(NoPlanError, match="no path"):
        options = QueryOptions(max_iterations=200)
        query(
            PlanningProblem(_roadmap(), wall(gap=-0.1), space(), START, GOAL[None], seed=1, options=options)
        )


def _check(route: CoarseRoute, world: BoxWorld, start: np.ndarray, goal: np.ndarray) -> None:
    np.testing.assert_array_equal(route.path.waypoints[[0, -1]], [start, goal])
    assert world.is_valid_path(route.path.waypoints)


def _roadmap_only() -> QueryOptions:
    """The roadmap's answer whatever it costs."""
    return QueryOptions(n_competing_plans=0)


def _seconds(path: JointPath) -> float:
    return estimated_duration(space(), path.waypoints)


def _each_alone(seed: int, options: QueryOptions) -> list[float]:
    """Durations of the roadmap's answer and of each of the planner's, with nobody to compete against."""
    stored = query(
        PlanningProblem(_over(), SCREEN, space(), START, GOAL[None], seed=seed, options=_roadmap_only())
    )
    problem = PlanningProblem(_over(), SCREEN, space(), START, GOAL[None], seed, options)
    ways = [problem.plan(START, GOAL[None], f"direct {k}") for k in range(options.n_competing_plans)]
    found = [JointPath(space().joint_names, way) for way in ways if way is not None]
    own = derived_seed(seed, "shorten")
    short = [shorten(SCREEN, space(), path, seed=own, iterations=options.n_shortcuts) for path in found]
    return [_seconds(stored.path), *map(_seconds, short)]


def _over() -> Roadmap:
    """Two nodes joined high above a screen."""
    roadmap = Roadmap.empty(space().joint_names)
    way = np.array([[-0.9, 0.9], [-0.9, 0.99], [0.9, 0.99], [0.9, 0.9]])
    roadmap, a = roadmap.with_node(way[0])
    roadmap, b = roadmap.with_node(way[-1])
    return roadmap.with_edge(a, b, way)


def _roadmap() -> Roadmap:
    """Two nodes on either side of the wall, joined through its gap."""
    roadmap = Roadmap.empty(space().joint_names)
    roadmap, a = roadmap.with_node(np.array([-0.5, 0.9]), "left")
    roadmap, b = roadmap.with_node(np.array([0.5, 0.9]), "right")
    return roadmap.with_edge(a, b, np.array([[-0.5, 0.9], [0.5, 0.9]]))


def _two_ways() -> Roadmap:
    """The same with a longer edge above."""
    return _roadmap().with_edge(0, 1, np.array([[-0.5, 0.9], [0.0, 0.97], [0.5, 0.9]]) * [1, 1])


def test_what_stands_in_the_straight_way_is_named_where_no_path_is_found() -> None:
    world = wall(gap=0.0)
    options = QueryOptions(max_iterations=200)
    with pytest.raises(NoPlanError, match="no path") as caught:
        query(
            PlanningProblem(
                Roadmap.empty(space().joint_names), world, space(), START, GOAL[None], seed=1, options=options
            )
        )
    assert caught.value.in_the_way == ("box 0",)
