"""One coarse motion for the database: several tries, the fastest in earnest."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from pickcli.cell.model import Cell
from pickcli.cell.robot import PivotState
from pickcli.collision.checker import SceneChecker
from pickcli.collision.model import CollisionModel
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.path import JointPath
from pickcli.motion.segment import SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.precompute.empty_scene import RESERVE, checker
from pickcli.roadmap.cost import estimated_duration
from pickcli.roadmap.database import CoarseMotion, MotionKey, PayloadClass
from pickcli.roadmap.planners import PlannerName
from pickcli.roadmap.polish import polish
from pickcli.roadmap.sampling import plan
from pickcli.roadmap.shorten import shorten
from pickcli.roadmap.space import JointSpace
from pickcli.seeds import derived_seed
from pickcli.timing.run import RunPart, time_run


@dataclass(frozen=True)
class TrajectorySettings:
    """How a database is built; all of it is stored with the result.

    n_tries: paths per pair that compete by estimated duration
    n_finalists: of these, the ones that are polished and timed; the fastest in earnest is kept
    """

    planner: PlannerName = PlannerName.RRT_CONNECT
    n_tries: int = 8
    n_finalists: int = 3
    max_iterations: int = 5000
    n_shortcuts: int = 150
    n_polish: int = 300
    seed: int = 0


@dataclass(frozen=True, eq=False)
class MotionMaker:
    """Makes motions of one cell. Each depends on its key and the settings alone."""

    cell: Cell
    settings: TrajectorySettings

    def make(self, key: MotionKey) -> CoarseMotion | Reason:
        """The best motion of a pair in the widest pivot state that allows one; else why there is none.

        MOVING covers the other states; where it allows nothing, the state that both ends are meant for.
        """
        pivots = {self.cell.configurations[name].pivot for name in (key.start, key.goal)}
        made = self._in_state(key, PivotState.MOVING)
        if isinstance(made, Reason) and len(pivots) == 1:
            made = self._in_state(key, pivots.pop())
        return made

    def _in_state(self, key: MotionKey, pivot: PivotState) -> CoarseMotion | Reason:
        tests = self._planning[pivot, key.payload]
        for name in (key.start, key.goal):
            q = self.cell.configurations[name].q
            if not tests.is_free(q):
                reason = tests.explain(q)
                return Reason(reason.what, name, reason.detail)
        finalists = self._finalists(key, tests)
        timed = [self._timed(self._proving[pivot, key.payload], path) for path in finalists]
        k = min(range(len(timed)), key=lambda k: timed[k].duration, default=None)
        if k is None:
            what = f"{self.settings.planner} gave up {self.settings.n_tries} times"
            return Reason("no path", f"{key.start} to {key.goal}", what)
        return CoarseMotion(key, pivot, finalists[k], timed[k].duration, timed[k])

    def _finalists(self, key: MotionKey, tests: SceneChecker) -> list[JointPath]:
        """The best tries, polished; one alone where the straight edge is free."""
        tries: list[JointPath] = []
        for attempt in range(self.settings.n_tries):
            path = self._try(tests, key, self._seed(key, f"try {attempt}"))
            if path is not None and len(path.waypoints) == 2:
                return [path]
            tries += [] if path is None else [path]
        tries.sort(key=lambda path: estimated_duration(self._space, path.waypoints))
        polished = [
            polish(
                tests, self._space, path, seed=self._seed(key, "polish"), iterations=self.settings.n_polish
            )
            for path in tries[: self.settings.n_finalists]
        ]
        return [path for path in polished if tests.path_is_free(path.waypoints) == -1]

    def _try(self, tests: SceneChecker, key: MotionKey, seed: int) -> JointPath | None:
        """One path, shortened."""
        q_start, q_goal = (self.cell.configurations[name].q for name in (key.start, key.goal))
        found = plan(
            tests,
            self._space,
            q_start,
            q_goal[None],
            seed=seed,
            planner=self.settings.planner,
            max_iterations=self.settings.max_iterations,
        )
        if found is None:
            return None
        return shorten(tests, self._space, found, seed=seed, iterations=self.settings.n_shortcuts)

    def _timed(self, tests: SceneChecker, path: JointPath) -> Trajectory:
        """The path in time at the cell's full speed, its blended corners proven as well."""

        def is_free(part: int, chords: Array, slack: Array | None) -> int:
            return tests.path_is_free(chords, slack)

        part = RunPart(SegmentKind.TRANSIT, path.waypoints, self.cell.speed_scale)
        return time_run(path.joint_names, [part], self.cell.robot.limits, is_free).trajectory

    def _seed(self, key: MotionKey, task: str) -> int:
        return derived_seed(self.settings.seed, key.start, key.goal, key.payload, task)

    @cached_property
    def _space(self) -> JointSpace:
        return JointSpace.of(self.cell.robot, self.cell.speed_scale)

    @cached_property
    def _planning(self) -> dict[tuple[PivotState, PayloadClass], SceneChecker]:
        """Checkers that planning asks: with the reserve."""
        return self._checkers(RESERVE)

    @cached_property
    def _proving(self) -> dict[tuple[PivotState, PayloadClass], SceneChecker]:
        """Checkers that the timed path is proven with: the cell's clearance, no more."""
        return self._checkers(0.0)

    def _checkers(self, reserve: float) -> dict[tuple[PivotState, PayloadClass], SceneChecker]:
        return {
            (pivot, load): checker(self._model, pivot, load, reserve)
            for pivot in PivotState
            for load in PayloadClass
        }

    @cached_property
    def _model(self) -> CollisionModel:
        return CollisionModel(self.cell)
