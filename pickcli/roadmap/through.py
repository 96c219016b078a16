"""The way through the roadmap: link of the start, A*, link of a goal."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.geometry import Array
from pickcli.roadmap.astar import shortest_route
from pickcli.roadmap.connect import Link, Problem, planned_link, straight_links, with_links
from pickcli.roadmap.graph import Roadmap


@dataclass(frozen=True, eq=False)
class ThroughRoute:
    """A proven way through the roadmap, not yet shortened."""

    waypoints: Array  # (K, n)
    nodes: tuple[int, ...]  # nodes of the roadmap on the way
    links: tuple[Array, ...]  # polylines of the new edges on the way: of the start and of the goal reached
    dropped: tuple[int, ...]  # stored edges that are not free now


def through_roadmap(problem: Problem) -> ThroughRoute | None:
    """The shortest way by stored edges, each proven again; None where the roadmap leads to no goal."""
    first = straight_links(problem, problem.q_start) or planned_link(problem, problem.q_start, "start link")
    last = _goal_links(problem) if first else []
    if not last:
        return None
    enlarged, nodes = with_links(problem.roadmap, [(problem.q_start, first), *last])
    return _search(problem, enlarged, nodes[0], nodes[1:])


def _goal_links(problem: Problem) -> list[tuple[Array, list[Link]]]:
    """The goals that have links, with them: straight ones, else for a few goals planned ones."""
    options = problem.options
    straight = [(goal, straight_links(problem, goal)) for goal in problem.goals[: options.n_goals]]
    linked = [(goal, links) for goal, links in straight if links]
    if linked:
        return linked
    planned = [
        (goal, planned_link(problem, goal, f"goal link {i}"))
        for i, goal in enumerate(problem.goals[: options.n_planned_goals])
    ]
    return [(goal, links) for goal, links in planned if links]


def _search(problem: Problem, enlarged: Roadmap, start: int, ends: list[int]) -> ThroughRoute | None:
    """A* on the roadmap with start and goals linked."""
    n_nodes, n_edges = problem.roadmap.n_nodes, problem.roadmap.n_edges

    def is_valid(edge: int) -> bool:
        # Links have just been proven; what is stored was proven in another scene.
        return edge >= n_edges or problem.checker.path_is_free(enlarged.edge_path(edge)) == -1

    route, dropped = shortest_route(enlarged, start, ends, is_valid)
    if route is None:
        return None
    new = [edge for edge in route.edges if edge >= n_edges]
    return ThroughRoute(
        enlarged.joined(route.nodes, route.edges),
        tuple(node for node in route.nodes if node < n_nodes),
        tuple(enlarged.edge_path(edge) for edge in new),
        dropped,
    )
