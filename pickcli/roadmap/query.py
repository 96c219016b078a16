"""Coarse queries: a straight edge, else the best path of roadmap and planner."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from pickcli.errors import Failures, NoPlanError, Reason
from pickcli.geometry import Array
from pickcli.motion.path import JointPath
from pickcli.path_planning.path_cost import edge_costs, estimated_duration
from pickcli.path_planning.shortcutting import shorten
from pickcli.path_planning.state_space import JointSpace
from pickcli.roadmap.connection import PlanningProblem
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.roadmap_search import RoadmapRoute, search_roadmap
from pickcli.seeds import derived_seed


class RouteSource(StrEnum):
    """Origin of a query's result."""

    STRAIGHT = "straight edge"
    ROADMAP = "roadmap"
    PLANNER = "planner"


@dataclass(frozen=True, eq=False)
class CoarseRoute:
    """A proven coarse motion.

    Attributes:
        path: The motion, from the start to one of the goals.
        goal: Index into the goals of the query.
        source: Origin of the motion.
        nodes: Roadmap nodes along it before shortening, by name or #index.
        dropped: Stored edges that are not free in this scene, by the names of their ends.
        new: New polylines (K, n) for the roadmap: connections of start and goal, or the planner's path; none
            for a straight edge, which needs no search.
    """

    path: JointPath
    goal: int
    source: RouteSource
    nodes: tuple[str, ...]
    dropped: tuple[tuple[str, str], ...]
    new: tuple[Array, ...]


def query(problem: PlanningProblem, label: str = "coarse motion") -> CoarseRoute:
    """Plan the coarse motion from a start to the goal that is reached fastest.

    A straight edge to the cheapest goal that has one is returned at once. Otherwise start and goals are
    connected to the roadmap and A* searches it; every stored edge is proven again in the current scene. If
    that takes longer than about the straight line's duration, the planner competes, a few times. All paths
    are shortened; every edge is proven by the problem's checker. The same arguments give the same bytes.

    Args:
        problem: The start and the goals, in any order; some goals may not be free.
        label: Name of the motion, for messages.

    Returns:
        The motion.

    Raises:
        NoPlanError: Start or goals are not free, or the planner gave up; with the reasons.
    """
    space, q_start, goals = problem.space, problem.q_start, problem.goals
    free = _free_goals(problem, label)
    order = sorted(free, key=lambda g: _cost(space, np.stack([q_start, goals[g]])))
    usable = replace(problem, goals=goals[order])
    route = _straight(usable) or _quickest(usable, label)
    return replace(route, goal=order[route.goal])


def _free_goals(problem: PlanningProblem, label: str) -> list[int]:
    """Return indices of the usable goals, at least one; raise NoPlanError if none is, or the start is not."""
    if (reason := _why_not(problem, problem.q_start, "start")) is not None:
        raise NoPlanError(label, [reason])
    reasons = [_why_not(problem, goal, f"goal {g}") for g, goal in enumerate(problem.goals)]
    free = [g for g, reason in enumerate(reasons) if reason is None]
    if not free:
        raise NoPlanError(label, [reason for reason in reasons if reason is not None])
    return free


def _why_not(problem: PlanningProblem, q: Array, where: str) -> Reason | None:
    """Return the reason that makes a configuration (n,) unusable, or None."""
    if not problem.space.holds(q):
        return Reason("joint limit", where, _outside(problem.space, q))
    if not problem.checker.is_valid(q):
        return problem.checker.explain(q).at(where)
    return None


def _outside(space: JointSpace, q: Array) -> str:
    """Describe which joint violates its limit, and by how much."""
    if np.shape(q) != (space.n,) or not np.all(np.isfinite(q)):
        return f"expected {space.n} finite numbers"
    excess = np.maximum(space.lower - q, q - space.upper)
    j = int(np.argmax(excess))
    return f"{space.joint_names[j]} at {q[j]:.4f} is {excess[j]:.2g} outside of its limits"


def _straight(problem: PlanningProblem) -> CoarseRoute | None:
    """Return the straight edge to the first goal that has one."""
    for goal in problem.goals:
        if problem.checker.is_valid_edge(problem.q_start, goal):
            path = JointPath(problem.space.joint_names, np.stack([problem.q_start, goal]))
            return CoarseRoute(path, _goal(problem, path), RouteSource.STRAIGHT, (), (), ())
    return None


def _quickest(problem: PlanningProblem, label: str) -> CoarseRoute:
    """Return the fastest of the routes of roadmap and planner."""
    enough = problem.options.enough * _duration(problem, np.stack([problem.q_start, problem.goals[0]]))
    best, least = None, np.inf
    for route in _competing_routes(problem):
        duration = _duration(problem, route.path.waypoints)
        if duration < least:
            best, least = route, duration
        if least <= enough:
            break
    if best is None:
        raise NoPlanError(label, _why_none(problem))
    return best


def _why_none(problem: PlanningProblem) -> Failures:
    """Return the reasons: no planner found a path, and the obstacles on the straight line to each goal."""
    detail = f"{problem.options.planner} gave up after {problem.options.max_iterations} iterations"
    met = (problem.checker.explain_edge(problem.q_start, goal) for goal in problem.goals)
    return Failures.of(Reason("no path", "", detail), *met)


def _competing_routes(problem: PlanningProblem) -> Iterator[CoarseRoute]:
    """Yield the route through the roadmap, then the planner's paths until it fails."""
    through = search_roadmap(problem)
    if through is not None:
        yield _stored(problem, through)
    for k in range(problem.options.n_competing_plans):
        waypoints = problem.plan(problem.q_start, problem.goals, f"direct {k}")
        if waypoints is None:
            return
        path = _shortened(problem, waypoints)
        yield CoarseRoute(path, _goal(problem, path), RouteSource.PLANNER, (), (), (path.waypoints,))


def _stored(problem: PlanningProblem, through: RoadmapRoute) -> CoarseRoute:
    """Build a route from stored edges."""
    roadmap = problem.roadmap
    path = _shortened(problem, through.waypoints)
    nodes = tuple(_name(roadmap, node) for node in through.nodes)
    dropped = tuple(
        (_name(roadmap, a), _name(roadmap, b)) for a, b in roadmap.edges[list(through.dropped)].tolist()
    )
    return CoarseRoute(path, _goal(problem, path), RouteSource.ROADMAP, nodes, dropped, through.links)


def _shortened(problem: PlanningProblem, waypoints: Array) -> JointPath:
    return shorten(
        problem.checker,
        problem.space,
        JointPath(problem.space.joint_names, waypoints),
        seed=derived_seed(problem.seed, "shorten"),
        iterations=problem.options.n_shortcuts,
    )


def _goal(problem: PlanningProblem, path: JointPath) -> int:
    return int(np.argmin(np.abs(problem.goals - path.end).max(axis=1)))


def _duration(problem: PlanningProblem, waypoints: Array) -> float:
    return estimated_duration(problem.space, waypoints)


def _cost(space: JointSpace, waypoints: Array) -> float:
    return float(edge_costs(space, waypoints).sum())


def _name(roadmap: Roadmap, node: int) -> str:
    return roadmap.names[node] or f"#{node}"
