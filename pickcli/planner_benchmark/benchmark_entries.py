"""Entries of the benchmark: geometric planners, and the minimum-time search."""

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
from pickcli.kernel import ParabolicTrajectory
from pickcli.motion.path import JointPath
from pickcli.motion.segment import PathSegment, SegmentKind, SegmentLimits
from pickcli.motion.trajectory import Trajectory
from pickcli.path_planning.planner_names import PlannerName
from pickcli.path_planning.planner_options import PlannerOptions
from pickcli.path_planning.sampling_planner import plan
from pickcli.path_planning.shortcutting import shorten
from pickcli.path_planning.state_space import JointSpace
from pickcli.precompute.empty_cell_checkers import STORED_RESERVE, checker
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.timing.timed_run import time_run
from pickcli.trajopt.jerk_filter import filter_jerk
from pickcli.trajopt.minimum_time_search import MinimumTimeSearch
from pickcli.trajopt.parabolic_segment import parabolic_limits
from pickcli.trajopt.proven_clearance import is_proven
from pickcli.trajopt.time_lower_bound import lower_bound, scaled_limits
from pickcli.trajopt.trajectory_settings import TrajectorySettings
from pickcli.trajopt.trajectory_validator import TrajectoryValidator

BLEND = 0.02  # joint units by which blends may leave a path


@dataclass(frozen=True)
class PlannerRun:
    """Result of one planner for one query.

    The minimum-time search has no path before shortening: ``found`` equals ``length`` then.

    Attributes:
        planning: s of wall clock until a path was found.
        whole: s of wall clock until it was shortened and timed.
        found: Length of the original path, m and rad mixed.
        length: Length of the shortened path.
        duration: s of the motion under the cell's limits, from rest to rest.
        cost_bound: How many times the least cost on its graph the original path costs at most, as proven by
            a search; None of planners that prove none.
    """

    planning: float
    whole: float
    found: float
    length: float
    duration: float
    cost_bound: float | None = None


@dataclass(frozen=True, eq=False)
class BenchmarkQuery:
    """A query from one free configuration to another, or to any of several.

    Planning keeps a reserve that the proof does not require.

    Attributes:
        cell: The cell.
        start: (n,) start.
        goals: (G, n) goals.
        planning: Checker with the reserve.
        proving: Checker without the reserve.
    """

    cell: Cell
    start: Array
    goals: Array
    planning: SceneChecker
    proving: SceneChecker

    @classmethod
    def of(
        cls, cell: Cell, model: CollisionModel, names: tuple[str, str], payload: PayloadClass
    ) -> BenchmarkQuery:
        """Build the query between two named configurations.

        The tool is in the state of both, or changes state if these differ.

        Args:
            cell: The cell.
            model: The robot's collision model in it.
            names: Start and goal.
            payload: Payload class in the cup.

        Returns:
            The query.
        """
        a, b = (cell.configurations[name] for name in names)
        tool_state = a.tool_state if a.tool_state == b.tool_state else MOVING
        validators = (checker(model, tool_state, payload, reserve) for reserve in (STORED_RESERVE, 0.0))
        return cls(cell, a.q, b.q[None], *validators)

    @cached_property
    def space(self) -> JointSpace:
        """The joint space at the cell's full speed."""
        return JointSpace.of(self.cell.robot, self.cell.speed_scale)

    @cached_property
    def limits(self) -> Limits:
        """Limits of the joints at the cell's full speed."""
        return scaled_limits(self.cell.robot.limits, self.cell.speed_scale)

    @property
    def bound(self) -> float:
        """Lower bound on the duration of any motion to any goal, s."""
        return min(lower_bound(self.limits, self.start, goal) for goal in self.goals)


class BenchmarkEntry(Protocol):
    """Interface of planners in the benchmark."""

    @property
    def name(self) -> str:
        """Name of the planner in the table."""

    def answer(self, query: BenchmarkQuery, seed: int) -> PlannerRun | None:
        """Plan one query; repeatable by seed except for the wall clock.

        Args:
            query: Start and goal.
            seed: Seed of all random choices.

        Returns:
            The result, or None.
        """


@dataclass(frozen=True)
class GeometricEntry:
    """A sampling-based planner with shortening, blending of corners and timing.

    All of them use the straight edge if it is free. RRT-Connect ends with its first path; RRT* and AORRTC
    improve theirs until all iterations are used.

    Attributes:
        planner: Name of the planner.
        max_iterations: Most iterations.
        n_shortcuts: Shortcuts tried in the path.
    """

    planner: PlannerName
    max_iterations: int = 3000
    n_shortcuts: int = 200

    @property
    def name(self) -> str:
        """Name of the planner."""
        return str(self.planner)

    def answer(self, query: BenchmarkQuery, seed: int) -> PlannerRun | None:
        """Plan one query; repeatable by seed except for the wall clock.

        Args:
            query: Start and goal.
            seed: Seed of all random choices.

        Returns:
            The result, or None.
        """
        began = time.perf_counter()
        options = PlannerOptions(self.planner, self.max_iterations)
        found = plan(query.planning, query.space, query.start, query.goals, seed=seed, options=options)
        planned = time.perf_counter()
        if found is None:
            return None
        path = shorten(query.planning, query.space, found, seed=seed, iterations=self.n_shortcuts)
        try:
            duration = timed_duration(query, path)
        except NoPlanError:  # a blend at a corner that could not be proven
            return None
        return PlannerRun(planned - began, time.perf_counter() - began, found.length, path.length, duration)


@dataclass(frozen=True)
class MinimumTimeEntry:
    """The minimum-time search of the trajectory database.

    Attributes:
        settings: Effort of the search.
        good: Factor on the lower bound; a motion of at most this duration ends the search.
    """

    settings: TrajectorySettings
    good: float = 1.01

    @property
    def name(self) -> str:
        """Name of the search in the table."""
        return "search in time"

    def answer(self, query: BenchmarkQuery, seed: int) -> PlannerRun | None:
        """Search one query; repeatable by seed except for the wall clock.

        Args:
            query: Start and one goal.
            seed: Seed of all random choices.

        Returns:
            The result, or None.
        """
        began = time.perf_counter()
        limits, proof = parabolic_limits(query.limits), TrajectoryValidator(query.proving, query.space)
        search = MinimumTimeSearch(
            TrajectoryValidator(query.planning, query.space),
            query.planning,
            limits,
            (query.start, query.goals[0]),
            self.settings,
        )
        names = query.cell.robot.joint_names

        def finish(motion: ParabolicTrajectory) -> Trajectory | None:
            timed = filter_jerk(names, motion, query.goals[0], limits, query.limits)
            return timed if is_proven(timed, proof) else None

        best = search.minimum_time(seed, finish, self.good * query.bound)
        if best is None:
            return None
        spent, length = time.perf_counter() - began, JointPath(names, best.positions).length
        return PlannerRun(spent, spent, length, length, best.duration)


def timed_duration(query: BenchmarkQuery, path: JointPath) -> float:
    """Time a path with blended corners, proven, under the cell's limits.

    Args:
        query: The query that the path answers.
        path: The path.

    Returns:
        s from rest to rest.

    Raises:
        NoPlanError: A blend could not be proven.
    """

    def is_free(part: int, chords: Array, slack: Array | None) -> int:
        return query.proving.first_blocked_edge(chords, slack)

    limits = SegmentLimits(speed_scale=query.cell.speed_scale, blend_tolerance=BLEND)
    segment = PathSegment(SegmentKind.TRANSIT, path.waypoints, limits)
    return time_run(path.joint_names, [segment], query.cell.robot.limits, is_free).trajectory.duration
