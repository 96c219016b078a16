"""Coarse motions outside the bins: to whichever of several goals the whole motion is fastest.

A straight edge first, then what was precomputed, then the planner (KTH, section IV-A.1; Delft, section 1):
``roadmap.query`` does the searching and proves every stored edge again in the scene as it is. Here the
goals are weighed by what the rest of the motion costs from each of them.
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

COARSE = SegmentLimits(blend_tolerance=0.05)
PROMISING = 3  # goals that a search is worth: those with the least time if nothing were in the way


@dataclass(frozen=True, eq=False)
class CoarsePath:
    """A proven polyline to one of several goals.

    Attributes:
        waypoints: (N, n) configurations.
        goal: Index into the goals that were given.
        duration: s, estimated.
        source: What found it: "straight edge", "database", "roadmap" or "planner".
        experience: What the search for it found that was not stored, if it was searched for at all.
    """

    waypoints: Array
    goal: int
    duration: float
    source: str
    experience: tuple[QueryExperience, ...] = ()

    def segment(self, kind: SegmentKind, mode: Mode) -> MotionSegment:
        """The motion as a segment that is proven in a mode.

        Args:
            kind: Kind of the segment.
            mode: The mode in which it is proven free.

        Returns:
            The segment.
        """
        return MotionSegment(kind, self.waypoints, COARSE, mode=mode)


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
        checker: What proves the motion.
        q_start: (n,) configuration at the start.
        goals: (G, n) configurations.
        extra: (G,) s that the motion still takes after each goal, so that the best whole motion wins.
        seed: Seed of all random choices.
        where: The motion, as reasons call it.

    Returns:
        The motion, or why there is none.
    """
    space = context.space
    least = [estimated_duration(space, np.stack([q_start, g])) for g in goals]
    order = np.argsort([d + e for d, e in zip(least, extra, strict=True)], kind="stable")
    straight = _straight(checker, q_start, goals, least, order)
    if straight is not None and straight.goal == order[0]:
        return straight  # nothing can beat a straight edge to the best goal
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
    """The fastest goal that a straight edge reaches."""
    for g in order:
        if checker.is_valid_edge(q_start, goals[g]):
            return CoarsePath(np.stack([q_start, goals[g]]), int(g), least[g], "straight edge")
    return None


def _searched(
    context: PlanningContext, checker: SceneChecker, q_start: Array, goals: Array, seed: int, where: str
) -> CoarsePath | Failures:
    """The path that the roadmap has, else one that the planner finds, else the reasons of both."""
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
    """A stored motion between two named configurations, if it is proven in the scene as it is."""
    for database in filter(None, (context.database, context.learned)):
        for g, goal in enumerate(goals):
            motion = database.between(q_start, goal, _payload(checker))
            if motion is not None and checker.is_valid_path(motion.path.waypoints):
                waypoints = motion.path.waypoints
                return CoarsePath(waypoints, g, estimated_duration(context.space, waypoints), "database")
    return None


def _payload(checker: SceneChecker) -> PayloadClass:
    return PayloadClass.EMPTY if checker.held is None else PayloadClass.CUBE
