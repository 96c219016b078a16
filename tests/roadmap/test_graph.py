"""The roadmap's bookkeeping."""

from __future__ import annotations

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.roadmap.graph import Roadmap


def test_additions_leave_the_old_roadmap_as_it_was() -> None:
    old, a = Roadmap.empty(("x", "y")).with_node(np.zeros(2), "a")
    new, b = old.with_node(np.ones(2), "b")
    joined = new.with_edge(a, b, np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 1.0]]))
    assert (old.n_nodes, new.n_nodes, new.n_edges, joined.n_edges) == (1, 2, 0, 1)
    assert joined.lengths[0] == 2.0
    assert joined.index("b") == b and joined.index("c") is None and joined.index("") is None


def test_an_edge_reads_from_either_end() -> None:
    roadmap = _line(3)
    path = roadmap.edge_path(1)
    np.testing.assert_array_equal(roadmap.edge_path(1, 1), path)
    np.testing.assert_array_equal(roadmap.edge_path(1, 2), path[::-1])


def test_an_edge_must_join_its_nodes() -> None:
    with pytest.raises(ValueError, match="does not lead"):
        _line(3).with_edge(0, 2, np.array([[0.0], [1.5]]))


def test_nearest_breaks_ties_by_index() -> None:
    assert _line(4).nearest(np.array([1.5]), 3) == [1, 2, 0]


@settings(max_examples=30, deadline=None)
@given(n=st.integers(1, 12), edges=st.lists(st.tuples(st.integers(0, 11), st.integers(0, 11)), max_size=15))
def test_components_agree_with_networkx(n: int, edges: list[tuple[int, int]]) -> None:
    roadmap = Roadmap.empty(("x",))
    for i in range(n):
        roadmap, _ = roadmap.with_node(np.array([float(i)]))
    graph = nx.empty_graph(n)
    for a, b in edges:
        if a < n and b < n and a != b:
            roadmap = roadmap.with_edge(a, b, roadmap.configurations[[a, b]])
            graph.add_edge(a, b)
    expected = {node: min(part) for part in nx.connected_components(graph) for node in part}
    assert roadmap.components().tolist() == [expected[i] for i in range(n)]


def _line(n: int) -> Roadmap:
    roadmap = Roadmap.empty(("x",))
    for i in range(n):
        roadmap, _ = roadmap.with_node(np.array([float(i)]))
    for i in range(n - 1):
        roadmap = roadmap.with_edge(i, i + 1, roadmap.configurations[[i, i + 1]])
    return roadmap
