"""Coarse motions outside the places, to that one of several goals with the fastest complete motion.

A straight edge is tried first, then precomputed motions, then roadmap and planner (KTH, section IV-A.1;
Delft, section 1); ``roadmap.query`` does so. This module poses the query, with the precomputed files of the
planning context, and returns its result as a path for a plan.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from pickcli.collision.checker import SceneChecker
from pickcli.errors import Failures, NoPlanError, Reason
from pickcli.geometry import Array
from pickcli.path_planning.ara_star import AraStarSettings
from pickcli.path_planning.lattice_planner import (
    LatticePlannerSettings,
    plan_on_lattice,
    shortcut_once,
)
from pickcli.path_planning.path_cost import estimated_duration
from pickcli.path_planning.workspace_lattice import HandGoals
from pickcli.planning.coarse_path import CoarsePath
from pickcli.planning.planning_context import PlanningContext
from pickcli.roadmap.connection import PlanningProblem, QueryOptions
from pickcli.roadmap.query import RouteSource, query
from pickcli.roadmap.query_experience import QueryExperience
from pickcli.roadmap.trajectory_database import PayloadClass


def plan_coarse(
    context: PlanningContext,
    checker: SceneChecker,
    q_start: Array,
    goals: Array,
    extra: Sequence[float],
    seed: int,
    where: str,
) -> CoarsePath | Failures:
    """Find a motion to any of several goals: of those found, the one with the fastest complete motion.

    Args:
        context: The cell, its models and its precomputed files.
        checker: Checker that proves the motion.
        q_start: (n,) configuration at the start.
        goals: (G, n) configurations.
        extra: (G,) s, cost of the rest of the motion after each goal.
        seed: Seed of all random choices.
        where: Name of the motion in reasons.

    Returns:
        The motion, or the reasons for failure.
    """
    settings, payload = context.settings, _payload(checker)
    problem = PlanningProblem(
        context.roadmap,
        checker,
        context.space,
        q_start,
        goals,
        seed,
        QueryOptions(max_iterations=settings.rrt_iterations, n_shortcuts=settings.shortcuts),
        np.asarray(extra),
        tuple(_precomputed(context, q_start, goals, payload)),
    )
    try:
        route = query(problem, where)
    except NoPlanError as error:
        return error.failures.within(where)
    is_new = route.source not in (RouteSource.STRAIGHT, RouteSource.DATABASE)
    experience = (QueryExperience(q_start, goals[route.goal], payload, route.new),) if is_new else ()
    return CoarsePath(route.path.waypoints, route.goal, route.duration, str(route.source), experience)


def plan_on_hand_lattice(
    context: PlanningContext, checker: SceneChecker, q_start: Array, goals: Array, most: int, where: str
) -> CoarsePath | Failures:
    """Find a motion of the empty tool to any of several goals by ARA*, with a proven bound on its cost.

    The planner of the PR2 system of 2013 (Cowley et al., IV-B): all goals are one set, the cost is the length
    of the path of the hand, and one pass of shortcuts follows. Nothing is random.

    Args:
        context: The cell and its models.
        checker: Checker that proves the motion.
        q_start: (n,) configuration at the start.
        goals: (G, n) configurations.
        most: Most expansions.
        where: Name of the motion in reasons.

    Returns:
        The motion, or the reason for failure.
    """
    if not checker.is_valid(q_start):
        return Failures.of(checker.explain(q_start).at(where))
    poses = HandGoals(context.arm.tips(goals, checker.tool_state), goals, in_any_turn=False)
    settings = LatticePlannerSettings(AraStarSettings(max_expansions=most))
    found = plan_on_lattice(context.arm, checker, q_start, poses, settings)
    if isinstance(found, Reason):
        return Failures.of(found.within(where))
    path = shortcut_once(checker, context.space, found.path)
    duration = estimated_duration(context.space, path.waypoints)
    return CoarsePath(path.waypoints, found.goal, duration, "lattice", searched=found)


def _precomputed(
    context: PlanningContext, q_start: Array, goals: Array, payload: PayloadClass
) -> Iterator[Array]:
    """Yield the stored motions (K, n) between start and goals that are configurations with a name."""
    for database in filter(None, (context.database, context.learned)):
        motions = (database.between(q_start, goal, payload) for goal in goals)
        yield from (motion.path.waypoints for motion in motions if motion is not None)


def _payload(checker: SceneChecker) -> PayloadClass:
    return PayloadClass.EMPTY if checker.held is None else PayloadClass.CUBE
