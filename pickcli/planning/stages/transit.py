"""Coarse motions outside the bins, to the one of several goals with the fastest complete motion.

A straight edge is tried first, then precomputed motions, then the planner (KTH, section IV-A.1; Delft,
section 1). ``roadmap.query`` searches and proves every stored edge again in the current scene. This module
weighs the goals by the cost of the rest of the motion from each of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pickcli.collision.checker import SceneChecker
from pickcli.collision.motion_segment import Mode, MotionSegment
from pickcli.errors import Failures, NoPlanError
from pickcli.geometry import Array
from pickcli.motion.segment import SegmentKind, SegmentLimits
from pickcli.path_planning.path_cost import estimated_duration
from pickcli.planning.planning_context import PlanningContext
from pickcli.roadmap.connection import PlanningProblem, QueryOptions
from pickcli.roadmap.query import query
from pickcli.roadmap.query_experience import QueryExperience
from pickcli.roadmap.trajectory_database import PayloadClass

COARSE_LIMITS = SegmentLimits(blend_tolerance=0.05)
PROMISING = 3  # goals that are searched first: those with the least estimated time without obstacles


@dataclass(frozen=True, eq=False)
class CoarsePath:
    """A proven path to one of several goals.

    Attributes:
        waypoints: (N, n) configurations.
        goal: Index into the given goals.
        duration: s, estimated.
        source: Its origin: "straight edge", "database", "roadmap" or "planner".
        experience: New experience of the search for it; empty if there was no search.
    """

    waypoints: Array
    goal: int
    duration: float
    source: str
    experience: tuple[QueryExperience, ...] = ()

    def segment(self, kind: SegmentKind, mode: Mode) -> MotionSegment:
        """Make a segment of the path.

        Args:
            kind: Kind of the segment.
            mode: The mode in which it is proven free.

        Returns:
            The segment.
        """
        return MotionSegment(kind, self.waypoints, COARSE_LIMITS, mode=mode)


def plan_coarse(
    context: PlanningContext,
    checker: SceneChecker,
    q_start: Array,
    goals: Array,
    extra: Sequence[float],
    seed: int,
    where: str,
) -> CoarsePath | Failures:
    """Find the fastest motion to any of several goals.

    Args:
        context: The cell, its models and its precomputed files.
        checker: Checker that proves the motion.
        q_start: (n,) configuration at the start.
        goals: (G, n) configurations.
        extra: (G,) s, cost of the rest of the motion after each goal, so that the best complete motion wins.
        seed: Seed of all random choices.
        where: Name of the motion in reasons.

    Returns:
        The motion, or the reasons for failure.
    """
    space = context.space
    least = [estimated_duration(space, np.stack([q_start, g])) for g in goals]
    order = np.argsort([d + e for d, e in zip(least, extra, strict=True)], kind="stable")
    straight = _straight(checker, q_start, goals, least, order)
    if straight is not None and straight.goal == order[0]:
        return straight  # no other motion can be faster
    searched = _searched(context, checker, q_start, goals[order[:PROMISING]], seed, where)
    if isinstance(searched, Failures) and straight is None:
        searched = _searched(context, checker, q_start, goals[order], seed, where)
    if isinstance(searched, Failures):
        return straight or searched
    found = replace(searched, goal=int(order[searched.goal]))
    if (
        straight is not None
        and straight.duration + extra[straight.goal] <= found.duration + extra[found.goal]
    ):
        return replace(straight, experience=found.experience)
    return found


def _straight(
    checker: SceneChecker, q_start: Array, goals: Array, least: Sequence[float], order: NDArray[np.intp]
) -> CoarsePath | None:
    """Return the straight edge to the fastest goal that one reaches, or None."""
    for g in order:
        if checker.is_valid_edge(q_start, goals[g]):
            return CoarsePath(np.stack([q_start, goals[g]]), int(g), least[g], "straight edge")
    return None


def _searched(
    context: PlanningContext, checker: SceneChecker, q_start: Array, goals: Array, seed: int, where: str
) -> CoarsePath | Failures:
    """Return a stored motion, else one of the roadmap or the planner, else the reasons of both."""
    stored = _stored(context, checker, q_start, goals)
    if stored is not None:
        return stored
    settings = context.settings
    options = QueryOptions(max_iterations=settings.rrt_iterations, n_shortcuts=settings.shortcuts)
    problem = PlanningProblem(context.roadmap, checker, context.space, q_start, goals, seed, options)
    try:
        route = query(problem, where)
    except NoPlanError as error:
        return error.failures.within(where)
    experience = QueryExperience(q_start, goals[route.goal], _payload(checker), route.new)
    duration = estimated_duration(context.space, route.path.waypoints)
    return CoarsePath(route.path.waypoints, route.goal, duration, str(route.source), (experience,))


def _stored(
    context: PlanningContext, checker: SceneChecker, q_start: Array, goals: Array
) -> CoarsePath | None:
    """Return a stored motion between two named configurations, if it is proven free in the current scene."""
    for database in filter(None, (context.database, context.learned)):
        for g, goal in enumerate(goals):
            motion = database.between(q_start, goal, _payload(checker))
            if motion is not None and checker.is_valid_path(motion.path.waypoints):
                waypoints = motion.path.waypoints
                return CoarsePath(waypoints, g, estimated_duration(context.space, waypoints), "database")
    return None


def _payload(checker: SceneChecker) -> PayloadClass:
    return PayloadClass.EMPTY if checker.held is None else PayloadClass.CUBE
