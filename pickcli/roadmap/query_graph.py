"""A roadmap with the start and the goals of one query connected to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.geometry import Array
from pickcli.roadmap.connection import Connection
from pickcli.roadmap.graph import Roadmap


@dataclass(frozen=True, eq=False)
class QueryGraph:
    """The graph that A* searches: a roadmap and configurations connected to it.

    The roadmap is not copied: its nodes and edges come first, with their indices.

    Attributes:
        roadmap: The stored roadmap, N nodes and M edges.
        configurations: (N + K, n) of the roadmap's nodes, then of the new ones.
        links: L pairs (node, connection): edges from new nodes to the roadmap's.
    """

    roadmap: Roadmap
    configurations: Array
    links: tuple[tuple[int, Connection], ...]

    def is_link(self, edge: int) -> bool:
        """Whether an edge is a connection of the query, and not an edge of the roadmap.

        Args:
            edge: Index of the edge.

        Returns:
            True for a connection.
        """
        return edge >= self.roadmap.n_edges

    @cached_property
    def lengths(self) -> Array:
        """(M + L,) Euclidean length of each edge."""
        steps = (np.linalg.norm(np.diff(link.waypoints, axis=0), axis=1).sum() for _, link in self.links)
        return np.concatenate([self.roadmap.lengths, [*steps]])

    @cached_property
    def neighbours(self) -> tuple[tuple[tuple[int, int], ...], ...]:
        """For each node its pairs (edge, other node), in order of the edges."""
        lists = list(self.roadmap.neighbours)
        lists += [()] * (len(self.configurations) - len(lists))
        for edge, (node, link) in enumerate(self.links, start=self.roadmap.n_edges):
            lists[node] = (*lists[node], (edge, link.node))
            lists[link.node] = (*lists[link.node], (edge, node))
        return tuple(lists)

    def edge_path(self, edge: int, start: int | None = None) -> Array:
        """Read the polyline of an edge or connection.

        Args:
            edge: Index of the edge.
            start: The node at which the polyline starts; None for the stored direction.

        Returns:
            (K, n) configurations, both ends included.
        """
        if not self.is_link(edge):
            return self.roadmap.edge_path(edge, start)
        _, link = self.links[edge - self.roadmap.n_edges]
        return link.waypoints[::-1] if start == link.node else link.waypoints

    def joined(self, nodes: Sequence[int], edges: Sequence[int]) -> Array:
        """Join the polylines along a route, without repeated configurations.

        Args:
            nodes: Indices of the nodes along the route.
            edges: Indices of the edges between them, one fewer.

        Returns:
            (K, n) polyline from the first node to the last.
        """
        ways = [self.edge_path(edge, start) for edge, start in zip(edges, nodes, strict=False)]
        return np.concatenate([self.configurations[nodes[0]][None], *(way[1:] for way in ways)])


def linked(
    roadmap: Roadmap, ends: Sequence[tuple[Array, Sequence[Connection]]]
) -> tuple[QueryGraph, list[int]]:
    """Connect configurations to a roadmap.

    A configuration that is already a node (see ``straight_connections``) stays that node.

    Args:
        roadmap: The roadmap.
        ends: Configurations (n,), each with at least one connection.

    Returns:
        The graph, and the node of each configuration.
    """
    nodes: list[int] = []
    new: list[Array] = []
    links: list[tuple[int, Connection]] = []
    for q, some in ends:
        if len(some[0].waypoints) == 1:
            nodes.append(some[0].node)
            continue
        nodes.append(roadmap.n_nodes + len(new))
        new.append(q)
        links += [(nodes[-1], link) for link in some]
    configurations = np.vstack([roadmap.configurations, *new]) if new else roadmap.configurations
    return QueryGraph(roadmap, configurations, tuple(links)), nodes
