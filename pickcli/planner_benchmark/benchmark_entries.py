"""Planners on one query, so that their answers can be compared: geometric ones, and our search in time."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from pickcli.cell.cell import Cell
from pickcli.cell.robot import Limits
from pickcli.cell.tool import MOVING
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import NoPlanError
from pickcli.geometry import Array
from pickcli.motion.path import JointPath
from pickcli.motion.segment import PathSegment, SegmentKind, SegmentLimits
from pickcli.motion.trajectory import Trajectory
from pickcli.path_planning.planner_names import PlannerName
from pickcli.path_planning.sampling_planner import plan
from pickcli.path_planning.shortcutting import shorten
from pickcli.path_planning.state_space import JointSpace
from pickcli.precompute.empty_cell_checkers import RESERVE, checker
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.timing.timed_run import time_run
from pickcli.trajopt.certified_clearance import is_proven
from pickcli.trajopt.jerk_filter import filter_jerk
from pickcli.trajopt.minimum_time_search import MinimumTimeSearch
from pickcli.trajopt.parabolic_segment import ParabolicLimits
from pickcli.trajopt.parabolic_trajectory import ParabolicTrajectory
from pickcli.trajopt.time_lower_bound import lower_bound, scaled_limits
from pickcli.trajopt.trajectory_settings import TrajectorySettings
from pickcli.trajopt.trajectory_validator import TrajectoryValidator

BLEND = 0.02  # joint units by which blends may leave a path


@dataclass(frozen=True)
class PlannerRun:
    """What one planner made of one query.

    planning: s of wall clock until it had a path; whole: until that was shortened and timed
    found, length: of the path as found and when shortened (m and rad mixed); a search in time has no former
    duration: s of the motion under the cell's limits, from rest to rest
    """

    planning: float
    whole: float
    found: float
    length: float
    duration: float


@dataclass(frozen=True, eq=False)
class BenchmarkQuery:
    """From one free configuration (n,) to another; planning keeps a reserve that the proof does not need."""

    cell: Cell
    ends: tuple[Array, Array]
    planning: SceneChecker
    proving: SceneChecker

    @classmethod
    def of(
        cls, cell: Cell, model: CollisionModel, names: tuple[str, str], payload: PayloadClass
    ) -> BenchmarkQuery:
        """Between two named configurations, in the pivot state of both, else while the cup pivots."""
        a, b = (cell.configurations[name] for name in names)
        tool_state = a.tool_state if a.tool_state == b.tool_state else MOVING
        tests = (checker(model, tool_state, payload, reserve) for reserve in (RESERVE, 0.0))
        return cls(cell, (a.q, b.q), *tests)

    @cached_property
    def space(self) -> JointSpace:
        """The joints at the cell's full speed."""
        return JointSpace.of(self.cell.robot, self.cell.speed_scale)

    @cached_property
    def limits(self) -> Limits:
        """Of the joints, at the cell's full speed."""
        return scaled_limits(self.cell.robot.limits, self.cell.speed_scale)

    @property
    def bound(self) -> float:
        """s that no motion can undercut."""
        return lower_bound(self.limits, *self.ends)


class BenchmarkEntry(Protocol):
    """Somebody who answers queries."""

    @property
    def name(self) -> str:
        """What the table calls it."""

    def answer(self, query: BenchmarkQuery, seed: int) -> PlannerRun | None:
        """The answer, or None; repeatable by seed but for the wall clock."""


@dataclass(frozen=True)
class GeometricEntry:
    """A sampling-based planner, its path shortened, its corners blended and timed.

    The straight edge is taken where it is free, by any of them. RRT-Connect ends with its first path; RRT*
    and AORRTC improve theirs until all iterations are used.
    """

    planner: PlannerName
    max_iterations: int = 3000
    n_shortcuts: int = 200

    @property
    def name(self) -> str:
        """See Contestant."""
        return str(self.planner)

    def answer(self, query: BenchmarkQuery, seed: int) -> PlannerRun | None:
        """See Contestant."""
        began = time.perf_counter()
        found = plan(
            query.planning, query.space, query.ends[0], query.ends[1][None],
            seed=seed, planner=self.planner, max_iterations=self.max_iterations,
        )  # fmt: skip
        planned = time.perf_counter()
        if found is None:
            return None
        path = shorten(query.planning, query.space, found, seed=seed, iterations=self.n_shortcuts)
        try:
            duration = _timed(query, path)
        except NoPlanError:  # a blend at a corner that could not be proven
            return None
        return PlannerRun(planned - began, time.perf_counter() - began, found.length, path.length, duration)


@dataclass(frozen=True)
class MinimumTimeEntry:
    """Our own search, that of the trajectory database: in time, not in length.

    settings: of the database, for its effort
    """

    settings: TrajectorySettings
    good: float = 1.01  # times the lower bound: what ends the search

    @property
    def name(self) -> str:
        """See Contestant."""
        return "search in time"

    def answer(self, query: BenchmarkQuery, seed: int) -> PlannerRun | None:
        """See Contestant."""
        began = time.perf_counter()
        pace, proof = ParabolicLimits.of(query.limits), TrajectoryValidator(query.proving, query.space)
        search = MinimumTimeSearch(
            TrajectoryValidator(query.planning, query.space), query.planning, pace, query.ends, self.settings
        )
        names = query.cell.robot.joint_names

        def finished(motion: ParabolicTrajectory) -> Trajectory | None:
            timed = filter_jerk(names, motion, query.ends[1], pace, query.limits)
            return timed if is_proven(timed, proof) else None

        best = search.quickest(seed, finished, self.good * query.bound)
        if best is None:
            return None
        spent, length = time.perf_counter() - began, JointPath(names, best.positions).length
        return PlannerRun(spent, spent, length, length, best.duration)


def _timed(query: BenchmarkQuery, path: JointPath) -> float:
    """s of the path with blended corners, proven, under the cell's limits."""

    def is_free(part: int, chords: Array, slack: Array | None) -> int:
        return query.proving.first_invalid_edge(chords, slack)

    limits = SegmentLimits(speed_scale=query.cell.speed_scale, blend_tolerance=BLEND)
    segment = PathSegment(SegmentKind.TRANSIT, path.waypoints, limits)
    return time_run(path.joint_names, [segment], query.cell.robot.limits, is_free).trajectory.duration
