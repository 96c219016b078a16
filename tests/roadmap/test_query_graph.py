"""A roadmap with links is the roadmap that has them as edges, without the copy."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pickcli.roadmap.connection import Connection
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.query_graph import linked

SEEDS = st.integers(0, 10_000)


def _roadmap(rng: np.random.Generator) -> Roadmap:
    roadmap = Roadmap.empty(("x", "y")).with_nodes(rng.normal(size=(6, 2)))
    pairs = [rng.permutation(6)[:2] for _ in range(8)]
    return roadmap.with_edges([(int(a), int(b), _way(rng, roadmap, a, b)) for a, b in pairs])


def _way(rng: np.random.Generator, roadmap: Roadmap, a: int, b: int) -> np.ndarray:
    between = rng.normal(size=(int(rng.integers(0, 3)), 2))
    return np.vstack([roadmap.configurations[a], between, roadmap.configurations[b]])


@given(SEEDS)
def test_it_is_the_enlarged_roadmap(seed: int) -> None:
    rng = np.random.default_rng(seed)
    roadmap, ends, edges = _roadmap(rng), [], []
    for k in range(3):
        q = rng.normal(size=2)
        links = [
            Connection(int(n), np.vstack([q, roadmap.configurations[n]])) for n in rng.permutation(6)[:2]
        ]
        ends.append((q, links))
        edges += [(6 + k, link.node, link.waypoints) for link in links]
    graph, nodes = linked(roadmap, ends)
    copy = roadmap.with_nodes(np.stack([q for q, _ in ends])).with_edges(edges)
    assert nodes == [6, 7, 8] and graph.neighbours == copy.neighbours
    np.testing.assert_array_equal(graph.configurations, copy.configurations)
    np.testing.assert_allclose(graph.lengths, copy.lengths, rtol=0, atol=1e-12)
    for edge, ends_of_edge in enumerate(copy.edges.tolist()):
        for start in ends_of_edge:
            np.testing.assert_array_equal(graph.edge_path(edge, start), copy.edge_path(edge, start))
        assert graph.is_link(edge) == (edge >= roadmap.n_edges)


def test_ways_are_joined_without_doubled_configurations() -> None:
    line = Roadmap.empty(("x",)).with_nodes(np.arange(3.0)[:, None])
    line = line.with_edges([(a, a + 1, line.configurations[[a, a + 1]]) for a in range(2)])
    graph, _ = linked(line, [])
    np.testing.assert_array_equal(graph.joined([2, 1, 0], [1, 0])[:, 0], [2.0, 1.0, 0.0])
    np.testing.assert_array_equal(graph.joined([2], []), [[2.0]])


def test_a_configuration_that_is_a_node_stays_that_node() -> None:
    roadmap = _roadmap(np.random.default_rng(0))
    q = roadmap.configurations[4]
    graph, nodes = linked(roadmap, [(q, [Connection(4, q[None])])])
    assert nodes == [4] and graph.neighbours == roadmap.neighbours
