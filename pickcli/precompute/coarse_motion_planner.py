"""One coarse motion for the database: as near to its lower bound as can be found.

The line itself where it is free; else a free motion in the time of the line, by bending what is not the
slowest joint; else in a little more time; else what RRT-Connect finds, made quicker. First for every pod
within the cell's bounds, then, where that fails or costs time, for the pod in its place.
See docs/precompute.md.
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
from pickcli.precompute.empty_cell_checkers import RESERVE, CheckerKey, checkers
from pickcli.roadmap.trajectory_database import CoarseMotion, MotionKey
from pickcli.seeds import derived_seed
from pickcli.trajopt.certified_clearance import is_proven, proven_clearance
from pickcli.trajopt.jerk_filter import filter_jerk
from pickcli.trajopt.minimum_time_search import MinimumTimeSearch
from pickcli.trajopt.parabolic_segment import TICK, parabolic_limits
from pickcli.trajopt.path_fitting import fit_polyline
from pickcli.trajopt.time_lower_bound import lower_bound, scaled_limits
from pickcli.trajopt.trajectory_settings import TrajectorySettings
from pickcli.trajopt.trajectory_validator import TrajectoryValidator

# Times the least duration: what a motion that holds in every tool state may take, ...
_WORTH = 1.01

# ... and what ends the search.
_GOOD = 1.01

# Times the motion for the pod in its place: what one for any pod may take and still be kept instead.
_AS_QUICK = 1.005

_SAMPLES = 60  # of a straight line whose depth tells how long a search will take


@dataclass(frozen=True, eq=False)
class CoarseMotionPlanner:
    """Makes motions of one cell. Each depends on the cell, its key and the settings alone.

    Cell, settings and keys can be pickled; a planner, which holds checkers, is made where it is used.

    Attributes:
        cell: The cell.
        settings: How motions are made.
    """

    cell: Cell
    settings: TrajectorySettings

    def make(self, key: MotionKey) -> CoarseMotion | Reason:
        """Make the best motion of a pair for any displaced pod.

        One for the pod in its place alone is made instead where only that is had, or where it is quicker.

        Args:
            key: Ends and payload class of the motion.

        Returns:
            The motion with its trajectory, or why there is none.
        """
        wide = self._for_pod_poses(key, PodPoses.DISPLACED)
        if isinstance(wide, Reason):
            return _marked(self._for_pod_poses(key, PodPoses.NOMINAL), f"for a displaced pod: {wide}")
        if wide.duration <= _GOOD * wide.lower_bound:
            return wide
        at_most = wide.duration / _AS_QUICK
        nominal = self._for_pod_poses(key, PodPoses.NOMINAL, at_most)
        if isinstance(nominal, CoarseMotion) and nominal.duration < at_most:
            return _marked(nominal, f"for a displaced pod it takes {wide.duration:.3f} s")
        return wide

    def depth(self, key: MotionKey) -> float:
        """Measure how deep the straight line between two configurations runs in something.

        Args:
            key: Ends and payload class of the motion.

        Returns:
            m by which it comes, at its worst, nearer than the margin to what any displaced pod may leave in
            its way; 0 if it keeps the margin.
        """
        checker = self._planning[PodPoses.DISPLACED, MOVING, key.payload]
        q0, q1 = (self.cell.configurations[name].q for name in (key.start, key.goal))
        line = q0 + np.linspace(0.0, 1.0, _SAMPLES)[:, None] * (q1 - q0)
        lacking = checker.margin - checker.kernel.clearances(line, checker.margin)
        return max(float(lacking.max()), 0.0)

    def _for_pod_poses(
        self, key: MotionKey, pod_poses: PodPoses, quicker_than: float = float("inf")
    ) -> CoarseMotion | Reason:
        """The best motion of a pair in the widest tool state that costs no time; else why there is none.

        MOVING covers the other states. Where it allows nothing, or nothing near the bound, the state that
        both ends are meant for is taken.

        quicker_than: s, what takes as long is not wanted
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
        """at_most: times the least duration."""
        checker = self._planning[case]
        q0, q1 = (self.cell.configurations[name].q for name in (key.start, key.goal))
        for name, q in ((key.start, q0), (key.goal, q1)):
            if not checker.is_valid(q):
                reason = checker.explain(q)
                return Reason(reason.what, name, reason.detail)
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
            _GOOD * lower_bound(self._limits, q0, q1),
            quicker_than,
            at_most * search.least + TICK,
        )
        if best is not None:
            return best
        straight = checker.explain_edge(q0, q1)
        detail = f"nor has {self.settings.planner} in {self.settings.n_tries} tries; on the line: {straight}"
        return Reason("no path", f"{key.start} to {key.goal}", f"bending has found none, {detail}")

    def _finished(self, key: MotionKey, case: CheckerKey, motion: ParabolicTrajectory) -> CoarseMotion | None:
        """The motion within its jerk limits, proven once more, with path and figures; None if not proven."""
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
        """Checkers that planning asks: with the reserve."""
        return checkers(self._model, RESERVE)

    @cached_property
    def _proving(self) -> dict[CheckerKey, SceneChecker]:
        """Checkers that the timed motion is proven with: the cell's clearance, no more."""
        return checkers(self._model)

    @cached_property
    def _model(self) -> CollisionModel:
        return CollisionModel(self.cell)


def _marked(nominal: CoarseMotion | Reason, why: str) -> CoarseMotion | Reason:
    """The motion for the nominal pod pose, marked with why there is none for all poses."""
    if isinstance(nominal, Reason):
        return nominal
    return replace(nominal, mark=PodValidity(PodPoses.NOMINAL, why))
