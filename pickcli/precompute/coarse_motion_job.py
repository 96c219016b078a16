"""The tasks of a trajectory database: one coarse motion each."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import PodPoses, PodValidity
from pickcli.cell.tool import ToolState
from pickcli.errors import Reason
from pickcli.jobs.job import Key
from pickcli.jobs.job_result import JobResult
from pickcli.motion.path import JointPath
from pickcli.motion.trajectory import Trajectory
from pickcli.precompute.coarse_motion_planner import CoarseMotionPlanner
from pickcli.precompute.provenance import inputs_digest
from pickcli.roadmap.trajectory_database import CoarseMotion, MotionKey, PayloadClass
from pickcli.trajopt.trajectory_settings import TrajectorySettings

_LEAST_EFFORT = 0.001  # m of collision depth that stands for the effort of a motion with a free line


@dataclass(frozen=True, eq=False)
class CoarseMotionJob:
    """Job that makes motions of one cell; the key of a task is (start, goal, payload class).

    Attributes:
        cell: The cell.
        settings: Settings of the motions.
    """

    cell: Cell
    settings: TrajectorySettings

    @cached_property
    def inputs(self) -> str:
        """SHA-256 over all inputs of a motion besides the key."""
        return inputs_digest(self.cell, "coarse motion", self.settings)

    def make(self, key: Key) -> JobResult:
        """Make one motion.

        Args:
            key: The task.

        Returns:
            The motion, or the reason for its absence, as a record.
        """
        return record_of(self._maker.make(motion_key(key)))

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
        values, arrays, n = result.values, result.arrays, len(self.cell.robot.joint_names)
        try:
            made_of(motion_key(key), result, self.cell.robot.joint_names)
            n_points, n_waypoints = len(arrays["times"]), len(arrays["waypoints"])
        except (KeyError, TypeError, ValueError) as error:
            return f"its fields are not those of a motion: {error}"
        shapes = {"times": (n_points,), "waypoints": (n_waypoints, n)}
        shapes |= dict.fromkeys(("positions", "velocities", "accelerations"), (n_points, n))
        numbers = (values[name] for name in ("duration", "lower_bound", "clearance"))
        is_sound = (
            min(n_points, n_waypoints) > 0
            and all(arrays[name].shape == shape for name, shape in shapes.items())
            and all(isinstance(number, float) for number in numbers)
        )
        return "" if is_sound else f"its arrays and numbers are not those of a motion of {n} joints"

    def effort(self, key: Key) -> float:
        """Estimate the cost of a task: motions whose straight line is deep in collision take long.

        Args:
            key: The task.

        Returns:
            Positive, without a unit.
        """
        return _LEAST_EFFORT + self._maker.depth(motion_key(key))

    def __reduce__(self) -> tuple[Any, ...]:
        # Without cached helpers, which belong to this process.
        return CoarseMotionJob, (self.cell, self.settings)

    @cached_property
    def _maker(self) -> CoarseMotionPlanner:
        return CoarseMotionPlanner(self.cell, self.settings)


def task_key(key: MotionKey) -> Key:
    """Return the key of the task that makes a motion.

    Args:
        key: The motion.

    Returns:
        The key of the task.
    """
    return (key.start, key.goal, str(key.payload))


def motion_key(key: Key) -> MotionKey:
    """Return the motion that a task makes.

    Args:
        key: The key of the task.

    Returns:
        The motion.
    """
    return MotionKey(key[0], key[1], PayloadClass(key[2]))


def record_of(made: CoarseMotion | Reason) -> JobResult:
    """Convert a motion, or the reason for its absence, to a record.

    Args:
        made: The motion with its trajectory, or the reason.

    Returns:
        The record.

    Raises:
        ValueError: The motion has no trajectory.
    """
    if isinstance(made, Reason):
        return JobResult(reason=made)
    timed = made.trajectory
    if timed is None:
        raise ValueError("a motion without its timed points cannot be kept")
    values = {
        "tool_state": str(made.tool_state),
        "duration": made.duration,
        "lower_bound": made.lower_bound,
        "clearance": made.clearance,
        **asdict(made.validity),
    }
    arrays = {
        "waypoints": made.path.waypoints,
        "times": timed.times,
        "positions": timed.positions,
        "velocities": timed.velocities,
        "accelerations": timed.accelerations,
    }
    return JobResult(values, arrays)


def made_of(key: MotionKey, record: JobResult, joint_names: tuple[str, ...]) -> CoarseMotion | Reason:
    """Read a motion, or the reason for its absence, from a record.

    Args:
        key: Ends and payload class of the motion.
        record: Record from ``record_of``.
        joint_names: Names of the n joints.

    Returns:
        The motion with its trajectory, or the reason.
    """
    if record.reason is not None:
        return record.reason
    v, a = record.values, record.arrays
    timed = Trajectory(joint_names, a["times"], a["positions"], a["velocities"], a["accelerations"])
    path = JointPath(joint_names, a["waypoints"])
    return CoarseMotion(
        key, ToolState(v["tool_state"]), path, v["duration"], timed, v["lower_bound"], v["clearance"],
        PodValidity(PodPoses(v["pod_poses"]), v["why_nominal"]),
    )  # fmt: skip
