"""Coarse motions outside the bins: straight edge, then what was precomputed, then the planner.

Between two named configurations the trajectory database answers, anything else the roadmap, a miss the
planner (KTH, section IV-A.1; Delft, section 1). What is stored is proven again against the scene as it
is; what fails drops out of this query. The fastest of what was found wins.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.collision.checker import SceneChecker
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.planning.context import Planner
from pickcli.roadmap.connect import query as query_roadmap
from pickcli.roadmap.sampling import plan as sample_path
from pickcli.roadmap.shorten import estimated_duration, shorten


@dataclass(frozen=True, eq=False)
class Coarse:
    """A proven polyline (N, n) to one of the goals."""

    waypoints: Array
    goal: int  # index into the goals that were given
    duration: float  # s, estimated
    source: str  # "straight", "roadmap", "planner"


def plan_coarse(
    planner: Planner, checker: SceneChecker, q_start: Array, goals: Array, extra: Sequence[float], seed: int, where: str
) -> Coarse | Reason:
    """The fastest motion found from q_start (n,) to any of the goals (G, n).

    extra: s that reaching each goal costs on top (the rest of its motion), so that the best whole motion
    wins. Reason when a start is not free or nothing was found.
    """
    if not checker.is_free(q_start):
        reason = checker.explain(q_start)
        return Reason(reason.what, f"{where}, start", reason.detail)
    straight = _straight(planner, checker, q_start, goals, extra)
    found = [] if straight is None else [straight]
    if straight is None or straight.goal != _nearest(planner, q_start, goals, extra):
        found += _searched(planner, checker, q_start, goals, extra, seed)
    if not found:
        reason = checker.explain_edge(q_start, goals[_nearest(planner, q_start, goals, extra)])
        return Reason("no coarse motion", where, f"the straight one fails by {reason}")
    return min(found, key=lambda c: c.duration + extra[c.goal])


def _duration(planner: Planner, waypoints: Array) -> float:
    return float(estimated_duration(waypoints, planner.arm.limits))


def _nearest(planner: Planner, q_start: Array, goals: Array, extra: Sequence[float]) -> int:
    """The goal with the least time if the straight edge to it were free: nothing can beat it."""
    return int(np.argmin([_duration(planner, np.stack([q_start, g])) + e for g, e in zip(goals, extra, strict=True)]))


def _straight(
    planner: Planner, checker: SceneChecker, q_start: Array, goals: Array, extra: Sequence[float]
) -> Coarse | None:
    """The fastest goal that a straight edge reaches."""
    edges = [np.stack([q_start, goal]) for goal in goals]
    durations = [_duration(planner, edge) for edge in edges]
    for g in np.argsort([d + e for d, e in zip(durations, extra, strict=True)], kind="stable"):
        if checker.edge_is_free(q_start, goals[g]):
            return Coarse(edges[g], int(g), durations[g], "straight")
    return None


def _searched(
    planner: Planner, checker: SceneChecker, q_start: Array, goals: Array, extra: Sequence[float], seed: int
) -> list[Coarse]:
    """What roadmap and planner find, shortened."""
    found = []
    if planner.roadmap is not None:
        route = query_roadmap(planner.roadmap, checker, q_start, goals, seed)
        if route is not None:
            found.append(_shortened(planner, checker, route.path.waypoints, goals, seed, "roadmap"))
    if not found:
        limits, settings = planner.arm.limits, planner.settings
        path = sample_path(
            checker, q_start, goals, limits.lower, limits.upper, seed=seed, max_iterations=settings.rrt_iterations
        )
        if path is not None:
            found.append(_shortened(planner, checker, path.waypoints, goals, seed, "planner"))
    return found


def _shortened(
    planner: Planner, checker: SceneChecker, waypoints: Array, goals: Array, seed: int, source: str
) -> Coarse:
    short = shorten(checker, waypoints, planner.arm.limits, seed=seed, n_iterations=planner.settings.shortcuts)
    goal = int(np.argmin(np.linalg.norm(goals - short[-1], axis=1)))
    return Coarse(short, goal, _duration(planner, short), source)
