"""Search of the roadmap: connection of the start, A*, connection of a goal."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.geometry import Array
from pickcli.roadmap.astar import shortest_route
from pickcli.roadmap.connection import Connection, PlanningProblem, planned_connection, straight_connections
from pickcli.roadmap.query_graph import QueryGraph, linked


@dataclass(frozen=True, eq=False)
class RoadmapRoute:
    """A proven route through the roadmap, not yet shortened.

    Attributes:
        waypoints: (K, n) from the start to the reached goal.
        nodes: Indices of the roadmap's nodes along it.
        links: Polylines (K, n) of the new edges: the connections of the start and of the reached goal.
        dropped: Indices of stored edges that are not free now.
    """

    waypoints: Array
    nodes: tuple[int, ...]
    links: tuple[Array, ...]
    dropped: tuple[int, ...]


def search_roadmap(problem: PlanningProblem) -> RoadmapRoute | None:
    """Find the shortest route along stored edges, each proven again.

    Args:
        problem: The query.

    Returns:
        The route; None if the roadmap leads to no goal.
    """
    first = straight_connections(problem, problem.q_start) or planned_connection(
        problem, problem.q_start, "start link"
    )
    last = _goal_links(problem) if first else []
    if not last:
        return None
    graph, nodes = linked(problem.roadmap, [(problem.q_start, first), *last])
    return _search(problem, graph, nodes[0], nodes[1:])


def _goal_links(problem: PlanningProblem) -> list[tuple[Array, list[Connection]]]:
    """Return the goals with their connections: straight ones, else for a few goals planned ones."""
    options = problem.options
    straight = [(goal, straight_connections(problem, goal)) for goal in problem.goals[: options.n_goals]]
    in_sight = [(goal, links) for goal, links in straight if links]
    if in_sight:
        return in_sight
    planned = [
        (goal, planned_connection(problem, goal, f"goal link {i}"))
        for i, goal in enumerate(problem.goals[: options.n_planned_goals])
    ]
    return [(goal, links) for goal, links in planned if links]


def _search(problem: PlanningProblem, graph: QueryGraph, start: int, ends: list[int]) -> RoadmapRoute | None:
    """Run A* on the roadmap with start and goals connected."""

    def is_valid(edge: int) -> bool:
        # Connections have just been proven; stored edges were proven in another scene.
        return graph.is_link(edge) or problem.checker.is_valid_path(problem.roadmap.edge_path(edge))

    route, dropped = shortest_route(graph, start, ends, is_valid)
    if route is None:
        return None
    return RoadmapRoute(
        graph.joined(route.nodes, route.edges),
        tuple(node for node in route.nodes if node < problem.roadmap.n_nodes),
        tuple(graph.edge_path(edge) for edge in route.edges if graph.is_link(edge)),
        dropped,
    )
