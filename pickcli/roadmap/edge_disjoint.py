"""Two routes that share no edge: what is left when an edge of the best route turns out to be blocked."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pickcli.roadmap.astar import Route
from pickcli.roadmap.graph import Roadmap

# An edge that carries a route, and the node that it carries it away from. Nothing is carried twice.
Flow = dict[int, int]

# Two ways round a circle must not look different by a rounding: the search would go round for ever.
_ROUNDING = 1e-12


@dataclass(frozen=True)
class EdgeDisjoint:
    """At most two routes between two nodes.

    Attributes:
        routes: None, the only one, or the two that share no edge and are shortest in sum; the shorter first.
        side: With fewer than two, the nodes on the start's side of a cut that at most one edge crosses; else
            none.
    """

    routes: tuple[Route, ...]
    side: frozenset[int] = frozenset()


def edge_disjoint(roadmap: Roadmap, start: int, goal: int) -> EdgeDisjoint:
    """Find the two routes between two nodes that share no edge and are shortest in sum.

    A flow of two units of least cost, by two shortest ways through what the flow leaves free (Suurballe 1974;
    Bhandari 1999). By Menger's theorem there are no two exactly where a cut of at most one edge parts the
    nodes; the nodes that a further way could still reach are one side of such a cut.

    Args:
        roadmap: The graph.
        start: Index of a node.
        goal: Index of another node.

    Returns:
        The routes or, where there are fewer than two, the cut as well.
    """
    flow: Flow = {}
    for found in range(2):
        came = _shortest_ways(roadmap, start, flow)
        if goal not in came:
            return EdgeDisjoint(_routes(roadmap, start, goal, flow, found), frozenset(came))
        _send(start, goal, came, flow)
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
    """For each node that can be reached, the (node, edge) before it on the shortest way.

    Way back along the flow is allowed and gives its cost back (Bellman and Ford, for costs below zero).
    """
    lengths = roadmap.lengths.tolist()
    cost, came, queue = {start: 0.0}, {start: (start, -1)}, deque([start])
    while queue:
        node = queue.popleft()
        for edge, other in roadmap.neighbours[node]:
            if flow.get(edge) == node:
                continue
            there = cost[node] + (-lengths[edge] if edge in flow else lengths[edge])
            if there < cost.get(other, np.inf) - _ROUNDING:
                cost[other], came[other] = there, (node, edge)
                if other not in queue:
                    queue.append(other)
    return came


def _send(start: int, goal: int, came: Mapping[int, tuple[int, int]], flow: Flow) -> None:
    """One more unit along the way to the goal; what goes back along the flow takes it away."""
    node = goal
    while node != start:
        node, edge = came[node]
        if edge in flow:
            del flow[edge]
        else:
            flow[edge] = node


def _routes(roadmap: Roadmap, start: int, goal: int, flow: Flow, count: int) -> tuple[Route, ...]:
    """The flow taken apart, shortest route first."""
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
