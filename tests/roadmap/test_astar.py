"""A* against networkx."""

from __future__ import annotations

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.roadmap.astar import shortest_route
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.query_graph import linked


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**31), n_nodes=st.integers(2, 30), share_blocked=st.floats(0, 0.9))
def test_agrees_with_networkx_on_the_graph_without_the_blocked_edges(
    seed: int, n_nodes: int, share_blocked: float
) -> None:
    rng = np.random.default_rng(seed)
    roadmap = _random_roadmap(rng, n_nodes)
    blocked = set(np.flatnonzero(rng.random(roadmap.n_edges) < share_blocked).tolist())
    start, *goals = rng.choice(n_nodes, size=min(4, n_nodes), replace=False).tolist()
    asked: list[int] = []

    def is_valid(edge: int) -> bool:
        asked.append(edge)
        return edge not in blocked

    route, dropped = shortest_route(roadmap, start, goals, is_valid)
    assert len(asked) == len(set(asked))  # nothing is proven twice
    assert set(dropped) == set(asked) & blocked
    expected = _oracle(roadmap, blocked, start, goals)
    if expected is None:
        assert route is None
        return
    assert route is not None
    assert route.cost == pytest.approx(expected)
    assert route.nodes[0] == start and route.nodes[-1] in goals
    assert not set(route.edges) & blocked
    joined = linked(roadmap, [])[0].joined(route.nodes, route.edges)
    np.testing.assert_array_equal(joined[[0, -1]], roadmap.configurations[[start, route.nodes[-1]]])
    assert np.linalg.norm(np.diff(joined, axis=0), axis=1).sum() == pytest.approx(expected)


def test_start_among_the_goals_costs_nothing() -> None:
    roadmap = _random_roadmap(np.random.default_rng(0), 5)
    route, dropped = shortest_route(roadmap, 2, [4, 2], lambda edge: False)
    assert route is not None and route.nodes == (2,) and route.cost == 0.0 and dropped == ()


def test_no_goal_no_route() -> None:
    roadmap = _random_roadmap(np.random.default_rng(0), 5)
    assert shortest_route(roadmap, 0, [], lambda edge: True) == (None, ())


def test_edges_that_cannot_win_are_never_asked() -> None:
    roadmap = Roadmap.empty(("x",))
    for x in (0.0, 1.0, 2.0, -50.0):
        roadmap, _ = roadmap.with_node(np.array([x]))
    for a, b in ((0, 1), (1, 2), (0, 3)):
        roadmap = roadmap.with_edge(a, b, roadmap.configurations[[a, b]])
    asked: list[int] = []

    def is_free(edge: int) -> bool:
        asked.append(edge)
        return True

    shortest_route(roadmap, 0, [2], is_free)
    assert asked == [0, 1]


def _random_roadmap(rng: np.random.Generator, n_nodes: int) -> Roadmap:
    """Edges with a middle point off the straight line, some of them double."""
    roadmap = Roadmap.empty(("x", "y", "z"))
    for q in rng.uniform(-1, 1, (n_nodes, 3)):
        roadmap, _ = roadmap.with_node(q)
    for _ in range(2 * n_nodes):
        a, b = rng.choice(n_nodes, size=2, replace=False)
        middle = roadmap.configurations[[a, b]].mean(axis=0) + rng.normal(0, 0.3, 3)
        path = np.stack([roadmap.configurations[a], middle, roadmap.configurations[b]])
        roadmap = roadmap.with_edge(int(a), int(b), path)
    return roadmap


def _oracle(roadmap: Roadmap, blocked: set[int], start: int, goals: list[int]) -> float | None:
    graph = nx.MultiGraph()
    graph.add_nodes_from(range(roadmap.n_nodes))
    for m, (a, b) in enumerate(roadmap.edges.tolist()):
        if m not in blocked:
            graph.add_edge(a, b, weight=roadmap.lengths[m])
    reached = nx.single_source_dijkstra_path_length(graph, start)
    costs = [reached[goal] for goal in goals if goal in reached]
    return min(costs) if costs else None
