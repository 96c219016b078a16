"""Links from a configuration to the roadmap."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.collision.motion_validator import MotionValidator
from pickcli.geometry import Array
from pickcli.path_planning.planner_names import PlannerName
from pickcli.path_planning.planner_options import PlannerOptions
from pickcli.path_planning.sampling_planner import plan
from pickcli.path_planning.state_space import JointSpace
from pickcli.roadmap.graph import Roadmap
from pickcli.seeds import derived_seed


@dataclass(frozen=True)
class QueryOptions:
    """How hard a coarse query tries. Everything is counted, nothing is timed.

    Attributes:
        planner: The planner that is asked where the roadmap does not help.
        max_iterations: Of the planner, each time that it is asked.
        n_nearest: Nodes that a start or goal is linked to, at most.
        n_goals: Goals that are linked to the roadmap, nearest first.
        n_planned_goals: Goals for which the planner searches a link, if no goal has a straight one.
        n_shortcuts: Shortcuts tried on a path that was found.
        enough: Times the straight line's duration: nothing quicker is searched for.
        n_competing_plans: Ways of the planner that compete with the roadmap's, each with a seed of its own.
    """

    planner: PlannerName = PlannerName.RRT_CONNECT
    max_iterations: int = 3000
    n_nearest: int = 6
    n_goals: int = 24
    n_planned_goals: int = 2
    n_shortcuts: int = 80
    enough: float = 1.05
    n_competing_plans: int = 4


DEFAULT_OPTIONS = QueryOptions()


@dataclass(frozen=True, eq=False)
class PlanningProblem:
    """One coarse query: from a start to any of several goals.

    Attributes:
        roadmap: The stored roadmap.
        checker: Proves configurations and edges in the scene as it is.
        space: The joints, their limits and speeds.
        q_start: (n,) configuration.
        goals: (G, n) configurations; the searches take them to be free, and the cheapest to come first.
        seed: Seed from which those of the planner are derived.
        options: How hard to try.
    """

    roadmap: Roadmap
    checker: MotionValidator
    space: JointSpace
    q_start: Array
    goals: Array
    seed: int
    options: QueryOptions = DEFAULT_OPTIONS

    def plan(self, q: Array, goals: Array, task: str) -> Array | None:
        """Ask the planner for a path to one of some goals.

        Args:
            q: (n,) configuration to start from.
            goals: (G, n) configurations, one of which is enough.
            task: Names the seed: the same task has the same seed.

        Returns:
            Proven waypoints (K, n), or None if the planner gave up.
        """
        path = plan(
            self.checker,
            self.space,
            q,
            goals,
            seed=derived_seed(self.seed, task),
            options=PlannerOptions(self.options.planner, self.options.max_iterations),
        )
        return None if path is None else path.waypoints


@dataclass(frozen=True, eq=False)
class Connection:
    """A proven polyline from a configuration to a node of the roadmap.

    Attributes:
        node: Index of the node.
        waypoints: (K, n), K >= 1, from the configuration to the node.
    """

    node: int
    waypoints: Array


def straight_connections(problem: PlanningProblem, q: Array) -> list[Connection]:
    """Link a configuration by straight proven edges to those of the nearest nodes that have one.

    A configuration that is a node is linked to it by a polyline of one point, and to nothing else.

    Args:
        problem: The query.
        q: (n,) configuration to link.

    Returns:
        The links, nearest node first; empty if there is none.
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
    """Link a configuration, by the planner, to whichever of the nearest nodes it reaches first.

    Args:
        problem: The query.
        q: (n,) configuration to link.
        task: Names the planner's seed.

    Returns:
        At most one link.
    """
    nodes = problem.roadmap.nearest(q, problem.options.n_nearest)
    waypoints = problem.plan(q, problem.roadmap.configurations[nodes], task) if nodes else None
    if waypoints is None:
        return []
    node = next(i for i in nodes if np.array_equal(problem.roadmap.configurations[i], waypoints[-1]))
    return [Connection(node, waypoints)]
