"""Links from a configuration to the roadmap."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.collision.motion_validator import MotionValidator
from pickcli.geometry import Array
from pickcli.path_planning.planner_names import PlannerName
from pickcli.path_planning.sampling_planner import plan
from pickcli.path_planning.state_space import JointSpace
from pickcli.roadmap.graph import Roadmap
from pickcli.seeds import derived_seed


@dataclass(frozen=True)
class QueryOptions:
    """How hard a coarse query tries. Everything is counted, nothing is timed."""

    planner: PlannerName = PlannerName.RRT_CONNECT
    max_iterations: int = 3000  # of the planner, each time that it is asked
    n_nearest: int = 6  # nodes that a start or goal is linked to, at most
    n_goals: int = 24  # goals that are linked to the roadmap, nearest first
    n_planned_goals: int = 2  # goals for which the planner searches a link, if no goal has a straight one
    n_shortcuts: int = 80
    enough: float = 1.05  # times the straight line's duration: nothing quicker is searched for
    n_rivals: int = 4  # ways of the planner that compete with the roadmap's, each with a seed of its own


@dataclass(frozen=True, eq=False)
class PlanningProblem:
    """One coarse query: from q_start (n,) to any of the goals (G, n), all of them free, cheapest first."""

    roadmap: Roadmap
    checker: MotionValidator
    space: JointSpace
    q_start: Array
    goals: Array
    seed: int
    options: QueryOptions

    def plan(self, q: Array, goals: Array, task: str) -> Array | None:
        """The planner's path (K, n) from q to one of the goals, or None. ``task`` names its seed."""
        path = plan(
            self.checker,
            self.space,
            q,
            goals,
            seed=derived_seed(self.seed, task),
            planner=self.options.planner,
            max_iterations=self.options.max_iterations,
        )
        return None if path is None else path.waypoints


@dataclass(frozen=True, eq=False)
class Connection:
    """A proven polyline (K, n) from a configuration to a node of the roadmap."""

    node: int
    waypoints: Array


def straight_connections(problem: PlanningProblem, q: Array) -> list[Connection]:
    """Links by a straight proven edge to those of the nearest nodes that have one.

    A configuration that is a node is linked to it by a polyline of one point, and to nothing else.
    """
    links = []
    for node in problem.roadmap.nearest(q, problem.options.n_nearest):
        there = problem.roadmap.configurations[node]
        if np.array_equal(there, q):
            return [Connection(node, q[None])]
        if problem.checker.is_valid_edge(q, there):
            links.append(Connection(node, np.stack([q, there])))
    return links


def planned_connection(problem: PlanningProblem, q: Array, task: str) -> list[Connection]:
    """At most one link, found by the planner, to whichever of the nearest nodes it reaches first."""
    nodes = problem.roadmap.nearest(q, problem.options.n_nearest)
    waypoints = problem.plan(q, problem.roadmap.configurations[nodes], task) if nodes else None
    if waypoints is None:
        return []
    node = next(i for i in nodes if np.array_equal(problem.roadmap.configurations[i], waypoints[-1]))
    return [Connection(node, waypoints)]
