"""Planner of coarse motions for the database, as near to their lower bounds as possible.

It tries the straight line; else a free motion of the line's duration, by bending the joints that are not the
slowest; else one of slightly longer duration; else a path by RRT-Connect, time-optimised. Motions are planned
for every pod pose within the cell's tolerance first and, if that fails or costs time, for the nominal pod
pose. See docs/precompute.md.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import PodPoses, PodValidity
from pickcli.cell.robot import Limits
from pickcli.cell.tool import MOVING
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import Reason
from pickcli.kernel import ParabolicLimits, ParabolicTrajectory
from pickcli.motion.path import JointPath
from pickcli.path_planning.state_space import JointSpace
from pickcli.precompute.empty_cell_checkers import STORED_RESERVE, CheckerKey, checkers
from pickcli.roadmap.trajectory_database import CoarseMotion, MotionKey
from pickcli.seeds import derived_seed
from pickcli.trajopt.jerk_filter import filter_jerk
from pickcli.trajopt.minimum_time_search import MinimumTimeSearch
from pickcli.trajopt.parabolic_segment import TICK, parabolic_limits
from pickcli.trajopt.path_fitting import fit_polyline
from pickcli.trajopt.proven_clearance import is_proven, proven_clearance
from pickcli.trajopt.time_lower_bound import lower_bound, scaled_limits
from pickcli.trajopt.trajectory_settings import TrajectorySettings
from pickcli.trajopt.trajectory_validator import TrajectoryValidator

# Factors on the least duration: up to the first, a motion that holds in every tool state is accepted; ...
_WORTH = 1.01

# ... up to the second, the search ends.
_GOOD_RATIO = 1.01

# Factor on the duration for the nominal pod pose, up to which a motion for all pod poses is preferred.
_AS_QUICK = 1.005

_SAMPLES = 60  # of a straight line, whose depth in collision estimates the effort of a search


@dataclass(frozen=True, eq=False)
class CoarseMotionPlanner:
    """Makes motions of one cell. Each depends only on the cell, its key and the settings.

    Cell, settings and keys can be pickled; a planner, which holds checkers, is built in the process that uses
    it.

    Attributes:
        cell: The cell.
        settings: Settings of the motions.
    """

    cell: Cell
    settings: TrajectorySettings

    def make(self, key: MotionKey) -> CoarseMotion | Reason:
        """Make the best motion of a pair for all pod poses.

        A motion for the nominal pod pose is returned instead if only that is found, or if it is faster.

        Args:
            key: Ends and payload class of the motion.

        Returns:
            The motion with its trajectory, or the reason for its absence.
        """
        wide = self._for_pod_poses(key, PodPoses.DISPLACED)
        if isinstance(wide, Reason):
            return _nominal_only(self._for_pod_poses(key, PodPoses.NOMINAL), f"for a displaced pod: {wide}")
        if wide.duration <= _GOOD_RATIO * wide.lower_bound:
            return wide
        at_most = wide.duration / _AS_QUICK
        nominal = self._for_pod_poses(key, PodPoses.NOMINAL, at_most)
        if isinstance(nominal, CoarseMotion) and nominal.duration < at_most:
            return _nominal_only(nominal, f"for a displaced pod it takes {wide.duration:.3f} s")
        return wide

    def depth(self, key: MotionKey) -> float:
        """Measure how deep the straight line between two configurations is in collision.

        Args:
            key: Ends and payload class of the motion.

        Returns:
            m by which it lacks, at its worst, the margin to solids at any displaced pod pose; 0 if it keeps
            the margin.
        """
        checker = self._planning[PodPoses.DISPLACED, MOVING, key.payload]
        q0, q1 = (self.cell.configurations[name].q for name in (key.start, key.goal))
        line = q0 + np.linspace(0.0, 1.0, _SAMPLES)[:, None] * (q1 - q0)
        lacking = checker.margin - checker.kernel.clearances(line, checker.margin)
        return max(float(lacking.max()), 0.0)

    def _for_pod_poses(
        self, key: MotionKey, pod_poses: PodPoses, quicker_than: float = float("inf")
    ) -> CoarseMotion | Reason:
        """Make the best motion of a pair in the widest tool state that costs no time, or return a reason.

        MOVING covers the other states. If it allows no motion, or none near the bound, the state that both
        ends are meant for is used.

        quicker_than: s, longest duration (exclusive) that is of use
        """
        tool_states = {self.cell.configurations[name].tool_state for name in (key.start, key.goal)}
        if len(tool_states) == 2:
            return self._motion_with(key, (pod_poses, MOVING, key.payload), quicker_than)
        wide = self._motion_with(key, (pod_poses, MOVING, key.payload), quicker_than, _WORTH)
        if isinstance(wide, CoarseMotion):
            return wide
        return self._motion_with(key, (pod_poses, tool_states.pop(), key.payload), quicker_than)

    def _motion_with(
        self, key: MotionKey, case: CheckerKey, quicker_than: float, at_most: float = float("inf")
    ) -> CoarseMotion | Reason:
        """Make the best motion for one checker. at_most: factor on the least duration."""
        checker = self._planning[case]
        q0, q1 = (self.cell.configurations[name].q for name in (key.start, key.goal))
        for name, q in ((key.start, q0), (key.goal, q1)):
            if not checker.is_valid(q):
                return checker.explain(q).at(name)
        search = MinimumTimeSearch(
            TrajectoryValidator(checker, self._space),
            checker,
            self._parabolic_limits,
            (q0, q1),
            self.settings,
        )
        seed = derived_seed(self.settings.seed, key.start, key.goal, key.payload, case[1])
        best = search.minimum_time(
            seed,
            lambda motion: self._finished(key, case, motion),
            _GOOD_RATIO * lower_bound(self._limits, q0, q1),
            quicker_than,
            at_most * search.least + TICK,
        )
        if best is not None:
            return best
        straight = checker.explain_path(np.stack([q0, q1]))
        detail = f"nor has {self.settings.planner} in {self.settings.n_tries} tries; on the line: {straight}"
        return Reason("no path", f"{key.start} to {key.goal}", f"bending has found none, {detail}")

    def _finished(self, key: MotionKey, case: CheckerKey, motion: ParabolicTrajectory) -> CoarseMotion | None:
        """Limit a motion's jerk and prove it again; add path, bound and clearance. None if not proven."""
        checker = self._proving[case]
        names = self.cell.robot.joint_names
        goal = self.cell.configurations[key.goal].q
        timed = filter_jerk(names, motion, goal, self._parabolic_limits, self._limits)
        if not is_proven(timed, TrajectoryValidator(checker, self._space)):
            return None
        waypoints = fit_polyline(timed, self._planning[case])
        if waypoints is None:
            return None
        bound = lower_bound(self._limits, waypoints[0], waypoints[-1])
        clearance = proven_clearance(timed, self._space, checker)
        pod_poses, tool_state, _ = case
        path = JointPath(names, waypoints)
        return CoarseMotion(
            key, tool_state, path, timed.duration, timed, bound, clearance, PodValidity(pod_poses)
        )

    @cached_property
    def _limits(self) -> Limits:
        return scaled_limits(self.cell.robot.limits, self.cell.speed_scale)

    @cached_property
    def _parabolic_limits(self) -> ParabolicLimits:
        return parabolic_limits(self._limits)

    @cached_property
    def _space(self) -> JointSpace:
        return JointSpace.of(self.cell.robot, self.cell.speed_scale)

    @cached_property
    def _planning(self) -> dict[CheckerKey, SceneChecker]:
        """Checkers for planning: with the reserve."""
        return checkers(self._model, STORED_RESERVE)

    @cached_property
    def _proving(self) -> dict[CheckerKey, SceneChecker]:
        """Checkers for proofs of the timed motion: the cell's clearance without reserve."""
        return checkers(self._model)

    @cached_property
    def _model(self) -> CollisionModel:
        return CollisionModel(self.cell)


def _nominal_only(nominal: CoarseMotion | Reason, why: str) -> CoarseMotion | Reason:
    """Mark the motion for the nominal pod pose with the reason for having none for all poses."""
    if isinstance(nominal, Reason):
        return nominal
    return replace(nominal, validity=PodValidity(PodPoses.NOMINAL, why))
