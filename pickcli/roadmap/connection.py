"""Connections from a configuration to the roadmap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

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
    """Effort of a coarse query. All limits are counts, not times.

    Attributes:
        planner: The planner that is used if the roadmap does not help.
        max_iterations: Iterations of each run of the planner.
        n_first_goals: Goals that are searched first; the others only if none of these is reached.
        n_nearest: Most nodes that a start or goal is connected to.
        n_goals: Most goals that are connected to the roadmap, nearest first.
        n_planned_goals: Goals for which the planner searches a connection, if no goal has a straight one.
        n_shortcuts: Shortcuts tried on a path.
        enough: Factor on the straight line's duration, below which the search ends.
        n_competing_plans: Paths of the planner that compete with the roadmap's, each with its own seed.
    """

    planner: PlannerName = PlannerName.RRT_CONNECT
    max_iterations: int = 3000
    n_first_goals: int = 3
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
        checker: Proves configurations and edges in the current scene.
        space: The joints, their limits and speeds.
        q_start: (n,) configuration.
        goals: (G, n) configurations; the searches assume them free, and the most promising first.
        seed: Seed from which those of the planner are derived.
        options: Effort of the search.
        costs_to_go: (G,) s, cost of the rest of the motion after each goal; None if all are equal.
        precomputed: Paths (K, n) from the start to a goal that were proven in another scene.
    """

    roadmap: Roadmap
    checker: MotionValidator
    space: JointSpace
    q_start: Array
    goals: Array
    seed: int
    options: QueryOptions = DEFAULT_OPTIONS
    costs_to_go: Array | None = None
    precomputed: tuple[Array, ...] = ()

    def with_goals(self, indices: Sequence[int]) -> PlanningProblem:
        """Return the problem with some of the goals.

        Args:
            indices: Indices of the goals to keep, in the new order.

        Returns:
            The smaller problem.
        """
        costs = None if self.costs_to_go is None else self.costs_to_go[list(indices)]
        return replace(self, goals=self.goals[list(indices)], costs_to_go=costs)

    def cost_to_go(self, goal: int) -> float:
        """Return the cost of the rest of the motion after a goal.

        Args:
            goal: Index of the goal.

        Returns:
            s.
        """
        return 0.0 if self.costs_to_go is None else float(self.costs_to_go[goal])

    def plan(self, q: Array, goals: Array, task: str) -> Array | None:
        """Run the planner for a path to one of some goals.

        Args:
            q: (n,) configuration to start from.
            goals: (G, n) configurations, one of which is enough.
            task: Name from which the seed is derived.

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
    """Connect a configuration by straight proven edges to all of the nearest nodes for which that succeeds.

    A configuration that is a node is connected only to it, by a polyline of one point.

    Args:
        problem: The query.
        q: (n,) configuration to connect.

    Returns:
        The connections, nearest node first; empty if there is none.
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
    """Connect a configuration, by the planner, to the one of the nearest nodes that it reaches first.

    Args:
        problem: The query.
        q: (n,) configuration to connect.
        task: Name from which the planner's seed is derived.

    Returns:
        At most one connection.
    """
    nodes = problem.roadmap.nearest(q, problem.options.n_nearest)
    waypoints = problem.plan(q, problem.roadmap.configurations[nodes], task) if nodes else None
    if waypoints is None:
        return []
    node = next(i for i in nodes if np.array_equal(problem.roadmap.configurations[i], waypoints[-1]))
    return [Connection(node, waypoints)]
