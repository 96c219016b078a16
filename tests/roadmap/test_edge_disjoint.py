"""Routes that share no edge, against networkx."""

from __future__ import annotations

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.roadmap.edge_disjoint import crossing, edge_disjoint
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.query_graph import linked


@st.composite
def roadmaps(draw: st.DrawFn) -> Roadmap:
    """Straight edges between random places, some of them double, and too few to connect everything."""
    n_nodes = draw(st.integers(2, 12))
    rng = np.random.default_rng(draw(st.integers(0, 2**31)))
    pairs = st.tuples(st.integers(0, n_nodes - 1), st.integers(0, n_nodes - 1)).filter(lambda p: p[0] != p[1])
    roadmap = Roadmap.empty(("x", "y"))
    for q in rng.uniform(-1, 1, (n_nodes, 2)):
        roadmap, _ = roadmap.with_node(q)
    for a, b in draw(st.lists(pairs, max_size=3 * n_nodes)):
        roadmap = roadmap.with_edge(a, b, roadmap.configurations[[a, b]])
    return roadmap


@settings(max_examples=300, deadline=None)
@given(roadmaps())
def test_there_are_as_many_and_they_are_as_short_as_networkx_says(roadmap: Roadmap) -> None:
    found = edge_disjoint(roadmap, 0, 1)
    flow = _directed(roadmap)
    flow.add_edge("source", ("node", 0), capacity=2, weight=0)
    value, _ = nx.maximum_flow(flow, "source", ("node", 1))
    assert len(found.routes) == value
    best = nx.cost_of_flow(flow, nx.max_flow_min_cost(flow, "source", ("node", 1)))
    assert sum(route.cost for route in found.routes) == pytest.approx(best / 1e9, abs=1e-6)


@settings(max_examples=300, deadline=None)
@given(roadmaps())
def test_routes_lead_from_start_to_goal_along_edges_that_no_other_takes(roadmap: Roadmap) -> None:
    routes = edge_disjoint(roadmap, 0, 1).routes
    taken = [edge for route in routes for edge in route.edges]
    assert len(taken) == len(set(taken))
    for route in routes:
        assert route.nodes[0] == 0 and route.nodes[-1] == 1
        joined = linked(roadmap, [])[0].joined(route.nodes, route.edges)
        np.testing.assert_array_equal(joined[[0, -1]], roadmap.configurations[[0, 1]])
        assert np.linalg.norm(np.diff(joined, axis=0), axis=1).sum() == pytest.approx(route.cost)
    assert [route.cost for route in routes] == sorted(route.cost for route in routes)


@settings(max_examples=300, deadline=None)
@given(roadmaps())
def test_where_there_are_no_two_a_cut_of_that_many_edges_says_why(roadmap: Roadmap) -> None:
    found = edge_disjoint(roadmap, 0, 1)
    if len(found.routes) == 2:
        assert found.side == frozenset()
        return
    assert 0 in found.side and 1 not in found.side
    assert len(crossing(roadmap, found.side)) == len(found.routes)


def test_the_shortest_route_gives_way_where_two_need_its_edges() -> None:
    # The shortest route is 0 2 3 1; taken away whole, it would part 0 from 1.
    roadmap = Roadmap.empty(("x", "y"))
    for q in ((0.0, 0.0), (3.0, 0.0), (1.0, 0.1), (2.0, -0.1)):
        roadmap, _ = roadmap.with_node(np.array(q))
    corners = {(0, 3): (1.0, -3.0), (2, 1): (2.0, 3.0)}
    for a, b in ((0, 2), (2, 3), (3, 1), (0, 3), (2, 1)):
        via = [corners[a, b]] if (a, b) in corners else []
        path = np.vstack([roadmap.configurations[a], *via, roadmap.configurations[b]])
        roadmap = roadmap.with_edge(a, b, path)
    assert {route.nodes for route in edge_disjoint(roadmap, 0, 1).routes} == {(0, 2, 1), (0, 3, 1)}


def _directed(roadmap: Roadmap) -> nx.DiGraph:
    """Each edge as one way there and one back, each by a node of its own as pairs may have several edges."""
    graph = nx.DiGraph()
    graph.add_nodes_from(("node", i) for i in range(roadmap.n_nodes))
    for m, (a, b) in enumerate(roadmap.edges.tolist()):
        for u, v in ((a, b), (b, a)):
            weight = round(1e9 * float(roadmap.lengths[m]))  # networkx wants whole numbers
            graph.add_edge(("node", u), ("edge", m, u), capacity=1, weight=weight)
            graph.add_edge(("edge", m, u), ("node", v), capacity=1, weight=0)
    return graph
