"""A* over a roadmap whose edges are proven again before they are used."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pickcli.geometry import Array


class Graph(Protocol):
    """A graph to be searched: a roadmap, or a query graph, which adds nodes and edges to one."""

    @property
    def configurations(self) -> Array:
        """(N, n) configurations of the nodes."""

    @property
    def lengths(self) -> Array:
        """(M,) lengths of the edges, never less than the distance of their ends."""

    @property
    def neighbours(self) -> tuple[tuple[tuple[int, int], ...], ...]:
        """For each node its pairs (edge, other node)."""


@dataclass(frozen=True)
class Route:
    """A path in the graph.

    Attributes:
        nodes: Indices of the nodes, from the start to the goal.
        edges: Indices of the edges; edges[i] joins nodes[i] and nodes[i + 1].
        cost: Sum of the lengths of the edges.
    """

    nodes: tuple[int, ...]
    edges: tuple[int, ...]
    cost: float


def shortest_route(
    graph: Graph,
    start: int,
    goals: Sequence[int],
    edge_is_valid: Callable[[int], bool],
) -> tuple[Route | None, tuple[int, ...]]:
    """Find the shortest route from start to any of the goals along valid edges.

    Lazy (after Dellin and Srinivasa 2016): only the edges of the currently best route are validated, each at
    most once; an invalid edge is dropped for this query and the search continues. So the result is the
    shortest route of the graph without all invalid edges.

    Args:
        graph: The graph.
        start: Index of the node to start from.
        goals: Indices of the nodes to reach, one of which is enough.
        edge_is_valid: Whether the edge with an index is free now.

    Returns:
        The route, None if there is none, and the indices of the dropped edges.
    """
    valid: set[int] = set()
    dropped: list[int] = []
    heuristic, lengths = _to_nearest(graph, goals), graph.lengths.tolist()
    while True:
        route = _search(graph, start, goals, heuristic, lengths, frozenset(dropped))
        if route is None:
            return None, tuple(dropped)
        failed = _first_failing(route, valid, edge_is_valid)
        if failed is None:
            return route, tuple(dropped)
        dropped.append(failed)


def _first_failing(route: Route, valid: set[int], edge_is_valid: Callable[[int], bool]) -> int | None:
    for edge in route.edges:
        if edge not in valid:
            if not edge_is_valid(edge):
                return edge
            valid.add(edge)
    return None


def _to_nearest(graph: Graph, goals: Sequence[int]) -> list[float]:
    """Return the distance of each node to the nearest goal, a lower bound of the route's length."""
    if not goals:
        return []
    to_goals = graph.configurations[:, None, :] - graph.configurations[list(goals)][None]
    distances: list[float] = np.linalg.norm(to_goals, axis=2).min(axis=1).tolist()
    return distances


def _search(
    graph: Graph,
    start: int,
    goals: Sequence[int],
    heuristic: Sequence[float],
    lengths: Sequence[float],
    dropped: frozenset[int],
) -> Route | None:
    """Find the shortest route to any goal, by A* on plain lists."""
    if not goals:
        return None
    targets = set(goals)
    cost = {start: 0.0}
    reached_from: dict[int, tuple[int, int]] = {}  # node -> (node before it, edge between)
    closed: set[int] = set()
    queue = [(heuristic[start], start)]
    while queue:
        _, node = heapq.heappop(queue)
        if node in targets:
            return _route(start, node, reached_from, cost[node])
        if node in closed:
            continue
        closed.add(node)
        for edge, other in graph.neighbours[node]:
            if edge in dropped or other in closed:
                continue
            candidate = cost[node] + lengths[edge]
            if candidate < cost.get(other, np.inf):
                cost[other], reached_from[other] = candidate, (node, edge)
                heapq.heappush(queue, (candidate + heuristic[other], other))
    return None


def _route(start: int, end: int, reached_from: dict[int, tuple[int, int]], cost: float) -> Route:
    nodes, edges = [end], []
    while nodes[-1] != start:
        before, edge = reached_from[nodes[-1]]
        nodes.append(before)
        edges.append(edge)
    return Route(tuple(reversed(nodes)), tuple(reversed(edges)), cost)
