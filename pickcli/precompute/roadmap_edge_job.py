"""The tasks of a roadmap: one edge each."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import ANY_POD, PodPoses, PodValidity
from pickcli.cell.tool import MOVING
from pickcli.collision.motion_validator import MotionValidator
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.jobs.job import Key
from pickcli.jobs.job_result import JobResult
from pickcli.motion.path import JointPath
from pickcli.path_planning.planner_names import PlannerName
from pickcli.path_planning.planner_options import PlannerOptions
from pickcli.path_planning.sampling_planner import plan
from pickcli.path_planning.shortcutting import shorten
from pickcli.path_planning.state_space import JointSpace
from pickcli.precompute.empty_cell_checkers import STORED_RESERVE, checker
from pickcli.precompute.provenance import inputs_digest
from pickcli.precompute.roadmap_settings import RoadmapSettings
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.seeds import derived_seed

# Factor on the length of the edge for the nominal pod pose, up to which one for all poses is preferred. RRT*
# varies that much by chance.
_AS_SHORT = 1.1


@dataclass(frozen=True, eq=False)
class RoadmapEdgeJob:
    """Job that makes edges between named configurations of one cell; a task's key is both names, sorted.

    Edges are proven for the tool in motion (MOVING), so that they hold in each tool state. An edge's seed
    is derived from the names of its ends.

    Attributes:
        cell: The cell.
        settings: Settings of the edges.
    """

    cell: Cell
    settings: RoadmapSettings

    @cached_property
    def inputs(self) -> str:
        """SHA-256 over all inputs of an edge besides the key."""
        return inputs_digest(self.cell, "roadmap edge", self.settings)

    def effort(self, key: Key) -> float:
        """Estimate the cost of a task; all edges count the same.

        Args:
            key: The task.

        Returns:
            1.
        """
        return 1.0

    def make(self, key: Key) -> JobResult:
        """Make one edge.

        Args:
            key: The task.

        Returns:
            A record with the edge's ``waypoints`` (N, n), ends included, and its validity, or with the reason
            for its absence.
        """
        wide = self._path(key, PodPoses.DISPLACED)
        if isinstance(wide, Reason):
            return _record(self._path(key, PodPoses.NOMINAL), f"for a displaced pod: {wide}")
        if wide.length > _AS_SHORT * float(np.linalg.norm(wide.end - wide.start)):
            nominal = self._path(key, PodPoses.NOMINAL)
            if isinstance(nominal, JointPath) and wide.length > _AS_SHORT * nominal.length:
                return _record(nominal, f"for a displaced pod its length is {wide.length:.2f}")
        return _record(wide)

    def misfit(self, key: Key, result: JobResult) -> str:
        """Tell why a result cannot be that of a task.

        Args:
            key: The task.
            result: A result that was read, of whatever content.

        Returns:
            The fault, as a phrase; "" if there is none.
        """
        if result.reason is not None:
            return ""
        try:
            validity_of(result)
            shape = result.arrays["waypoints"].shape
        except (KeyError, ValueError) as error:
            return f"its fields are not those of an edge: {error}"
        n = len(self.cell.robot.joint_names)
        is_path = len(shape) == 2 and shape[0] >= 2 and shape[1] == n
        return "" if is_path else f"its waypoints are no path of {n} joints: {list(shape)}"

    def _path(self, key: Key, pod_poses: PodPoses) -> JointPath | Reason:
        """Find the shortest path, or the reason for its absence."""
        validator, settings = self.checkers[pod_poses], self.settings
        seed = derived_seed(settings.seed, "edge", *key)
        q_start, q_goal = (self.cell.configurations[name].q for name in key)
        for name, q in zip(key, (q_start, q_goal), strict=True):
            if not validator.is_valid(q):
                return validator.explain(q).at(name)
        # If RRT* needs too long, RRT-Connect often finds a path at once.
        planners = list(dict.fromkeys((settings.planner, PlannerName.RRT_CONNECT)))
        tries = (self._planned(validator, q_start, q_goal, seed, planner) for planner in planners)
        found = next(filter(None, tries), None)
        if found is None:
            what = f"{' and '.join(planners)} gave up after {settings.max_iterations} iterations"
            return Reason("no path", detail=what)
        path = shorten(validator, self.space, found, seed=seed, iterations=settings.n_shortcuts)
        unproven = validator.first_blocked_edge(path.waypoints)
        if unproven != -1:
            return Reason("no proof", detail=f"edge {unproven} of the shortened path is not proven whole")
        return path

    def _planned(
        self, validator: MotionValidator, q_start: Array, q_goal: Array, seed: int, planner: PlannerName
    ) -> JointPath | None:
        options = PlannerOptions(planner, self.settings.max_iterations)
        return plan(validator, self.space, q_start, q_goal[None], seed=seed, options=options)

    def __reduce__(self) -> tuple[Any, ...]:
        # Without cached helpers, which belong to this process.
        return RoadmapEdgeJob, (self.cell, self.settings)

    @cached_property
    def space(self) -> JointSpace:
        """Joint space of the robot, in which edges are planned."""
        return JointSpace.of(self.cell.robot)

    @property
    def checker(self) -> MotionValidator:
        """Checker of configurations and edges for the nominal pod pose."""
        return self.checkers[PodPoses.NOMINAL]

    @cached_property
    def checkers(self) -> dict[PodPoses, MotionValidator]:
        """Checkers of configurations and edges, by poses of the pod."""
        model = CollisionModel(self.cell)
        return {
            pod_poses: checker(model, MOVING, PayloadClass.EMPTY, STORED_RESERVE, pod_poses)
            for pod_poses in PodPoses
        }


def _record(path: JointPath | Reason, why_nominal: str = "") -> JobResult:
    if isinstance(path, Reason):
        return JobResult(reason=path)
    validity = PodValidity(PodPoses.NOMINAL, why_nominal) if why_nominal else ANY_POD
    return JobResult(asdict(validity), {"waypoints": path.waypoints})


def validity_of(record: JobResult) -> PodValidity:
    """Return the pod validity of an edge's record.

    Args:
        record: Record of an edge.

    Returns:
        The validity.
    """
    return PodValidity(PodPoses(record.values["pod_poses"]), record.values["why_nominal"])
