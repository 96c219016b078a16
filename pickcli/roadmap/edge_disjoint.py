"""Edge-disjoint routes: a second route remains if an edge of the best one is blocked."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pickcli.roadmap.astar import Route
from pickcli.roadmap.graph import Roadmap

# By edge that carries a route: the node that it leads away from. No edge carries two.
Flow = dict[int, int]

# Two ways round a cycle must not differ by rounding: the search would loop forever.
_ROUNDING = 1e-12


@dataclass(frozen=True)
class EdgeDisjoint:
    """At most two routes between two nodes.

    Attributes:
        routes: None, the only one, or the two without a common edge and with the least total length; the
            shorter first.
        side: If fewer than two, the nodes on the start's side of a cut that at most one edge crosses; else
            empty.
    """

    routes: tuple[Route, ...]
    side: frozenset[int] = frozenset()


def edge_disjoint(roadmap: Roadmap, start: int, goal: int) -> EdgeDisjoint:
    """Find the two routes between two nodes that share no edge and have the least total length.

    A minimum-cost flow of two units, found by two shortest paths in the residual graph (Suurballe 1974;
    Bhandari 1999). By Menger's theorem there are no two routes exactly if a cut of at most one edge separates
    the nodes; the nodes that a further path could still reach are one side of such a cut.

    Args:
        roadmap: The graph.
        start: Index of a node.
        goal: Index of another node.

    Returns:
        The routes and, if there are fewer than two, the cut.
    """
    flow: Flow = {}
    for found in range(2):
        reached_from = _shortest_ways(roadmap, start, flow)
        if goal not in reached_from:
            return EdgeDisjoint(_routes(roadmap, start, goal, flow, found), frozenset(reached_from))
        _send(start, goal, reached_from, flow)
    return EdgeDisjoint(_routes(roadmap, start, goal, flow, 2))


def crossing(roadmap: Roadmap, side: frozenset[int]) -> tuple[int, ...]:
    """Find the edges that lead from one side of a cut to the other.

    Args:
        roadmap: The graph.
        side: Nodes on one side of the cut.

    Returns:
        Indices of the edges, in their order.
    """
    return tuple(m for m, (a, b) in enumerate(roadmap.edges.tolist()) if (a in side) != (b in side))


def _shortest_ways(roadmap: Roadmap, start: int, flow: Mapping[int, int]) -> dict[int, tuple[int, int]]:
    """Return for each reachable node the (node, edge) before it on the shortest way.

    Edges may be traversed against the flow, which refunds their cost (Bellman and Ford, for negative costs).
    """
    lengths = roadmap.lengths.tolist()
    cost, reached_from, queue = {start: 0.0}, {start: (start, -1)}, deque([start])
    while queue:
        node = queue.popleft()
        for edge, other in roadmap.neighbours[node]:
            if flow.get(edge) == node:
                continue
            there = cost[node] + (-lengths[edge] if edge in flow else lengths[edge])
            if there < cost.get(other, np.inf) - _ROUNDING:
                cost[other], reached_from[other] = there, (node, edge)
                if other not in queue:
                    queue.append(other)
    return reached_from


def _send(start: int, goal: int, reached_from: Mapping[int, tuple[int, int]], flow: Flow) -> None:
    """Add one unit of flow along the way to the goal; an edge traversed against the flow loses it."""
    node = goal
    while node != start:
        node, edge = reached_from[node]
        if edge in flow:
            del flow[edge]
        else:
            flow[edge] = node


def _routes(roadmap: Roadmap, start: int, goal: int, flow: Flow, count: int) -> tuple[Route, ...]:
    """Decompose the flow into routes, shortest first."""
    leaving: dict[int, list[int]] = {}
    for edge in sorted(flow):
        leaving.setdefault(flow[edge], []).append(edge)
    routes = []
    for _ in range(count):
        nodes, edges = [start], list[int]()
        while nodes[-1] != goal:
            edge = leaving[nodes[-1]].pop()
            edges.append(edge)
            nodes.append(int(roadmap.edges[edge].sum()) - nodes[-1])
        routes.append(Route(tuple(nodes), tuple(edges), float(roadmap.lengths[edges].sum())))
    return tuple(sorted(routes, key=lambda route: route.cost))
