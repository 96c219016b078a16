"""Coarse queries: a straight edge, else a precomputed path, else the best of roadmap and planner."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from itertools import takewhile

import numpy as np

from pickcli.errors import Failures, NoPlanError, Reason
from pickcli.geometry import Array
from pickcli.motion.path import JointPath
from pickcli.path_planning.path_cost import estimated_duration
from pickcli.path_planning.shortcutting import shorten
from pickcli.path_planning.state_space import JointSpace
from pickcli.roadmap.connection import PlanningProblem
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.roadmap_search import RoadmapRoute, search_roadmap
from pickcli.seeds import derived_seed


class RouteSource(StrEnum):
    """Origin of a query's result."""

    STRAIGHT = "straight edge"
    DATABASE = "database"
    ROADMAP = "roadmap"
    PLANNER = "planner"


@dataclass(frozen=True, eq=False)
class CoarseRoute:
    """A proven coarse motion.

    Attributes:
        path: The motion, from the start to one of the goals.
        goal: Index into the goals of the query.
        duration: s, estimated.
        source: Origin of the motion.
        nodes: Roadmap nodes along it before shortening, by name or #index.
        dropped: Stored edges that are not free in this scene, by the names of their ends.
        new: New polylines (K, n) for the roadmap: connections of start and goal, or the planner's path. Any
            search may leave some; straight edges and precomputed paths need no search.
    """

    path: JointPath
    goal: int
    duration: float
    source: RouteSource
    nodes: tuple[str, ...] = ()
    dropped: tuple[tuple[str, str], ...] = ()
    new: tuple[Array, ...] = ()


def query(problem: PlanningProblem, label: str = "coarse motion") -> CoarseRoute:
    """Plan a coarse motion from a start to one of several goals.

    Of the motions that are found, the one with the least sum of estimated duration and cost to go is
    returned. No motion to a goal is faster than the straight edge to it, so goals are searched in the order
    of that bound, and none whose bound is not below the best straight edge:

    1. A straight edge to the first goal is returned at once.
    2. Precomputed paths are proven again in the current scene; if one is free, nothing is searched.
    3. Start and goals are connected to the roadmap and A* searches it; every stored edge is proven again. If
       that takes longer than about the bound, the planner competes, a few times.

    Searched paths are shortened; every edge is proven by the problem's checker. The same arguments give the
    same bytes.

    Args:
        problem: The start and the goals, in any order; some goals may not be free.
        label: Name of the motion, for messages.

    Returns:
        The motion.

    Raises:
        NoPlanError: Start or goals are not free, or the planner gave up; with the reasons.
    """
    free = _free_goals(problem, label)
    least = [_bound(problem, goal) for goal in range(len(problem.goals))]
    order = sorted(free, key=least.__getitem__)
    route = _best(problem.with_goals(order), label)
    return replace(route, goal=order[route.goal])


def _free_goals(problem: PlanningProblem, label: str) -> list[int]:
    """Return indices of the usable goals, at least one; raise NoPlanError if none is, or the start is not."""
    if (reason := _why_not(problem, problem.q_start, "start")) is not None:
        raise NoPlanError(label, [reason])
    free = [g for g, goal in enumerate(problem.goals) if _is_usable(problem, goal)]
    if not free:
        reasons = (_why_not(problem, goal, f"goal {g}") for g, goal in enumerate(problem.goals))
        raise NoPlanError(label, [reason for reason in reasons if reason is not None])
    return free


def _is_usable(problem: PlanningProblem, q: Array) -> bool:
    return problem.space.holds(q) and problem.checker.is_valid(q)


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


def _best(problem: PlanningProblem, label: str) -> CoarseRoute:
    """Return the best motion to goals that are free and sorted by their bounds."""
    straight = _straight(problem)
    if straight is not None and _total(problem, straight) <= _bound(problem, 0):
        return straight
    faster = problem if straight is None else _with_bound_below(problem, _total(problem, straight))
    found = _precomputed(faster) or _searched(faster)
    if found is None and straight is None:
        raise NoPlanError(label, _why_none(problem))
    return min(filter(None, (straight, found)), key=partial(_total, problem))


def _straight(problem: PlanningProblem) -> CoarseRoute | None:
    """Return the straight edge to the first goal that has one: the best, as goals are sorted by bounds."""
    for g, goal in enumerate(problem.goals):
        if problem.checker.is_valid_edge(problem.q_start, goal):
            return _route(problem, np.stack([problem.q_start, goal]), g, RouteSource.STRAIGHT)
    return None


def _with_bound_below(problem: PlanningProblem, total: float) -> PlanningProblem:
    """Return the problem with the goals, sorted by bounds, that may be reached in less than ``total`` s."""
    goals = range(len(problem.goals))
    return problem.with_goals([*takewhile(lambda g: _bound(problem, g) < total, goals)])


def _precomputed(problem: PlanningProblem) -> CoarseRoute | None:
    """Return the best of the precomputed paths that are free in the current scene, or None."""
    routes = [
        _route(problem, path, g, RouteSource.DATABASE)
        for path in problem.precomputed
        for g in np.flatnonzero((problem.goals == path[-1]).all(axis=1))[:1].tolist()
    ]
    routes.sort(key=partial(_total, problem))
    return next((route for route in routes if problem.checker.is_valid_path(route.path.waypoints)), None)


def _searched(problem: PlanningProblem) -> CoarseRoute | None:
    """Return the best route to the first goals, else to any of all goals, else None."""
    n_first = problem.options.n_first_goals
    found = _quickest(problem.with_goals(range(min(n_first, len(problem.goals)))))
    return found or (_quickest(problem) if len(problem.goals) > n_first else None)


def _quickest(problem: PlanningProblem) -> CoarseRoute | None:
    """Return the best of the routes of roadmap and planner, or None."""
    straight = _bound(problem, 0) - problem.cost_to_go(0)
    enough = problem.options.enough * straight + problem.cost_to_go(0)
    best, least = None, np.inf
    for route in _competing_routes(problem):
        total = _total(problem, route)
        if total < least:
            best, least = route, total
        if least <= enough:
            break
    return best


def _why_none(problem: PlanningProblem) -> Failures:
    """Return the reasons: no planner found a path, and the obstacles on the straight line to each goal."""
    detail = f"{problem.options.planner} gave up after {problem.options.max_iterations} iterations"
    met = (problem.checker.explain_path(np.stack([problem.q_start, goal])) for goal in problem.goals)
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
        short = _shortened(problem, waypoints)
        yield replace(_route(problem, short, _goal(problem, short), RouteSource.PLANNER), new=(short,))


def _stored(problem: PlanningProblem, through: RoadmapRoute) -> CoarseRoute:
    """Build a route from stored edges."""
    roadmap = problem.roadmap
    short = _shortened(problem, through.waypoints)
    nodes = tuple(_name(roadmap, node) for node in through.nodes)
    dropped = tuple(
        (_name(roadmap, a), _name(roadmap, b)) for a, b in roadmap.edges[list(through.dropped)].tolist()
    )
    route = _route(problem, short, _goal(problem, short), RouteSource.ROADMAP)
    return replace(route, nodes=nodes, dropped=dropped, new=through.links)


def _shortened(problem: PlanningProblem, waypoints: Array) -> Array:
    path = JointPath(problem.space.joint_names, waypoints)
    seed, n_shortcuts = derived_seed(problem.seed, "shorten"), problem.options.n_shortcuts
    return shorten(problem.checker, problem.space, path, seed=seed, iterations=n_shortcuts).waypoints


def _route(problem: PlanningProblem, waypoints: Array, goal: int, source: RouteSource) -> CoarseRoute:
    path = JointPath(problem.space.joint_names, waypoints)
    return CoarseRoute(path, goal, estimated_duration(problem.space, waypoints), source)


def _goal(problem: PlanningProblem, waypoints: Array) -> int:
    return int(np.argmin(np.abs(problem.goals - waypoints[-1]).max(axis=1)))


def _bound(problem: PlanningProblem, goal: int) -> float:
    """Return the estimated time of the straight edge to a goal, obstacles ignored, and of the rest, s."""
    straight = np.stack([problem.q_start, problem.goals[goal]])
    return estimated_duration(problem.space, straight) + problem.cost_to_go(goal)


def _total(problem: PlanningProblem, route: CoarseRoute) -> float:
    return route.duration + problem.cost_to_go(route.goal)


def _name(roadmap: Roadmap, node: int) -> str:
    return roadmap.names[node] or f"#{node}"
