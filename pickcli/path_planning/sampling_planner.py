"""Common interface to all sampling-based planners in joint space."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module

import numpy as np

from pickcli.collision.motion_validator import MotionValidator
from pickcli.geometry import Array
from pickcli.kernel import rrt_connect
from pickcli.motion.path import JointPath
from pickcli.path_planning.planner_names import PlannerName
from pickcli.path_planning.planner_options import DEFAULT_OPTIONS, PlannerOptions
from pickcli.path_planning.state_space import JointSpace

# Largest distance of an end of a returned path from the requested one: copies of doubles are exact.
_END_TOLERANCE = 1e-12


def check_installed(planner: PlannerName) -> None:
    """Check that a planner's library is installed, before any work is done that would be lost without it.

    Args:
        planner: The planner.

    Raises:
        InputError: The extra with the library is missing.
    """
    if planner is not PlannerName.RRT_CONNECT:
        import_module("pickcli.path_planning.ompl_planners")


def plan(
    checker: MotionValidator,
    space: JointSpace,
    q_start: Array,
    goals: Array,
    *,
    seed: int,
    options: PlannerOptions = DEFAULT_OPTIONS,
) -> JointPath | None:
    """Plan a proven polyline to one of several goals.

    A straight edge to the nearest goal that has one is tried first: no sampling can be better. Otherwise the
    planner runs. The same arguments give the same bytes, in any process.

    Args:
        checker: Proves edges and configurations.
        space: Position limits and metric.
        q_start: (n,) start.
        goals: (G, n) goals.
        seed: Seed of all random choices.
        options: Planner and its effort.

    Returns:
        The path, or None if none was found.
    """
    q_start, goals = np.asarray(q_start, dtype=float), np.atleast_2d(np.asarray(goals, dtype=float))
    if not (space.holds(q_start) and checker.is_valid(q_start)):
        return None
    goals = goals[space.are_held(goals)]
    goals = goals[checker.are_valid(goals)]
    if len(goals) == 0:
        return None
    reachable = goals[np.argsort(np.linalg.norm(goals - q_start, axis=1), kind="stable")]
    # Most straight edges are blocked half-way: many middles are checked at once in less time than one edge.
    for goal in reachable[checker.are_valid((q_start + reachable) / 2)]:
        if checker.is_valid_edge(q_start, goal):
            return JointPath(space.joint_names, np.stack([q_start, goal]))
    waypoints = _solve(checker, space, q_start, reachable, seed, options)
    if waypoints is None or not _is_answer(checker, q_start, reachable, waypoints):
        return None
    return JointPath(space.joint_names, waypoints)


def _solve(
    checker: MotionValidator,
    space: JointSpace,
    q_start: Array,
    goals: Array,
    seed: int,
    options: PlannerOptions,
) -> Array | None:
    """Run the planner; the result (N, n) is not checked."""
    ends = np.vstack([q_start, goals])
    # An end may be slightly outside of the limits, and trees must be able to reach it.
    lower, upper = space.around(ends)
    if options.planner is PlannerName.RRT_CONNECT:
        longest, most = options.step * float(np.linalg.norm(upper - lower)), options.max_iterations
        waypoints = rrt_connect(
            checker.kernel, q_start, ends[1:], lower, upper, seed, most, longest, checker.margin
        )
        return waypoints if len(waypoints) else None
    from pickcli.path_planning import ompl_planners  # imported only when needed

    return ompl_planners.solve(
        checker, replace(space, lower=lower, upper=upper), q_start, list(goals), seed, options
    )


def _is_answer(checker: MotionValidator, q_start: Array, goals: Array, waypoints: Array) -> bool:
    """Whether a path has the requested ends and is proven; results of planners are always checked."""
    gap = np.abs(goals - waypoints[-1]).max(axis=1).min()
    return bool(
        len(waypoints) >= 2
        and np.abs(waypoints[0] - q_start).max() <= _END_TOLERANCE
        and gap <= _END_TOLERANCE
        and checker.is_valid_path(waypoints)
    )
