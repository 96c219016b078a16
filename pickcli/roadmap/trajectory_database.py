"""The database of coarse motions between named configurations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property

import numpy as np

from pickcli.cell.pod_tolerance import NOMINAL_POD, PodValidity
from pickcli.cell.tool import ToolState
from pickcli.geometry import Array
from pickcli.motion.path import JointPath
from pickcli.motion.trajectory import Trajectory
from pickcli.roadmap.graph import IntArray


class PayloadClass(StrEnum):
    """Payload that a stored motion was proven with; Delft planned all of theirs with an attached cube."""

    EMPTY = "empty"
    CUBE = "cube"  # 0.2 m, one face on the tool frame
    CENTRED_CUBE = "centred cube"  # 0.2 m, its centre at the tool frame: Delft's own


@dataclass(frozen=True)
class MotionKey:
    """Key of a stored motion.

    Attributes:
        start: Name of the start configuration.
        goal: Name of the goal configuration.
        payload: Payload class of the held item.
    """

    start: str
    goal: str
    payload: PayloadClass

    def reversed(self) -> MotionKey:
        """Reverse the key.

        Returns:
            The key of the reversed motion.
        """
        return MotionKey(self.goal, self.start, self.payload)


@dataclass(frozen=True, eq=False)
class CoarseMotion:
    """One stored motion, proven at its build in the empty cell with the cell's clearance.

    Attributes:
        key: Its ends and payload class.
        tool_state: State of the tool that it is valid for (MOVING covers the others).
        path: The polyline.
        duration: s, at full speed.
        trajectory: None if the timed points were not loaded.
        lower_bound: s that no motion between the two ends can undercut.
        clearance: m that the motion is proven to keep from everything.
        validity: Pod validity of the proof.
    """

    key: MotionKey
    tool_state: ToolState
    path: JointPath
    duration: float
    trajectory: Trajectory | None = None
    lower_bound: float = 0.0
    clearance: float = 0.0
    validity: PodValidity = NOMINAL_POD

    def reversed(self) -> CoarseMotion:
        """Reverse the motion; it is equally free, and within limits, which are symmetric.

        Returns:
            The motion from its goal to its start.
        """
        timed = self.trajectory
        back = None if timed is None else _reversed(timed)
        return replace(self, key=self.key.reversed(), path=self.path.reversed(), trajectory=back)


def _reversed(timed: Trajectory) -> Trajectory:
    return Trajectory(
        timed.joint_names,
        timed.duration - timed.times[::-1],
        timed.positions[::-1].copy(),
        -timed.velocities[::-1],
        timed.accelerations[::-1].copy(),
    )


@dataclass(frozen=True, eq=False)
class TimedPoints:
    """All trajectories one after the other; motion k has rows offsets[k]:offsets[k + 1].

    Attributes:
        times: (P,) s, each motion from 0.
        positions: (P, n) rad or m.
        velocities: (P, n) rad/s or m/s.
        accelerations: (P, n) rad/s^2 or m/s^2.
        offsets: (K + 1,) rows at which the motions begin, and P.
    """

    times: Array
    positions: Array
    velocities: Array
    accelerations: Array
    offsets: IntArray


@dataclass(frozen=True, eq=False)
class TrajectoryDatabase:
    """Coarse motions by (start, goal, payload class), as flat arrays and offsets.

    Each motion is stored once and can be looked up in both directions.

    Attributes:
        joint_names: Names of the n joints.
        keys: (K,) ends and payload class of each motion.
        tool_states: (K,) states of the tool that each is valid for.
        durations: (K,) s, at full speed.
        waypoints: (W, n) of all paths.
        offsets: (K + 1,) rows of ``waypoints`` at which the paths begin, and W.
        lower_bounds: (K,) s that no motion between the same ends can undercut.
        clearances: (K,) m that each motion is proven to keep from everything.
        validities: (K,) pod validity of each.
        points: The timed points, None if they were not loaded.
    """

    joint_names: tuple[str, ...]
    keys: tuple[MotionKey, ...]
    tool_states: tuple[ToolState, ...]
    durations: Array
    waypoints: Array
    offsets: IntArray
    lower_bounds: Array
    clearances: Array
    validities: tuple[PodValidity, ...]
    points: TimedPoints | None = None

    @classmethod
    def of(cls, joint_names: tuple[str, ...], motions: list[CoarseMotion]) -> TrajectoryDatabase:
        """Build a database of timed motions.

        Args:
            joint_names: Names of the n joints.
            motions: The motions, each with its trajectory.

        Returns:
            The database, in the order of the motions.

        Raises:
            ValueError: A motion has no trajectory.
        """
        timed = [motion.trajectory for motion in motions if motion.trajectory is not None]
        if len(timed) != len(motions):
            raise ValueError("every stored motion must be timed")
        empty = np.zeros((0, len(joint_names)))
        points = TimedPoints(
            np.concatenate([np.zeros(0), *(t.times for t in timed)]),
            np.concatenate([empty, *(t.positions for t in timed)]),
            np.concatenate([empty, *(t.velocities for t in timed)]),
            np.concatenate([empty, *(t.accelerations for t in timed)]),
            _offsets([len(t.times) for t in timed]),
        )
        return cls(
            joint_names,
            tuple(motion.key for motion in motions),
            tuple(motion.tool_state for motion in motions),
            np.array([motion.duration for motion in motions], dtype=float),
            np.concatenate([empty, *(motion.path.waypoints for motion in motions)]),
            _offsets([len(motion.path.waypoints) for motion in motions]),
            np.array([motion.lower_bound for motion in motions], dtype=float),
            np.array([motion.clearance for motion in motions], dtype=float),
            tuple(motion.validity for motion in motions),
            points,
        )

    def __len__(self) -> int:
        return len(self.keys)

    def __iter__(self) -> Iterator[CoarseMotion]:
        return (self._motion(k) for k in range(len(self)))

    def lookup(self, start: str, goal: str, payload: PayloadClass) -> CoarseMotion | None:
        """Find the motion between two named configurations.

        The caller must prove it again in the current scene.

        Args:
            start: Name of the start configuration.
            goal: Name of the goal configuration.
            payload: Payload class of the held item.

        Returns:
            The motion, reversed if necessary, or None if it is not stored.
        """
        key = MotionKey(start, goal, payload)
        if key in self._index:
            return self._motion(self._index[key])
        if key.reversed() in self._index:
            return self._motion(self._index[key.reversed()]).reversed()
        return None

    def between(self, q_start: Array, q_goal: Array, payload: PayloadClass) -> CoarseMotion | None:
        """Find the motion between two configurations that exactly equal ends of stored motions.

        Args:
            q_start: (n,) start configuration.
            q_goal: (n,) goal configuration.
            payload: Payload class of the held item.

        Returns:
            The motion, reversed if necessary, or None if it is not stored.
        """
        start, goal = (self._names.get(np.asarray(q, dtype=float).tobytes()) for q in (q_start, q_goal))
        return None if start is None or goal is None else self.lookup(start, goal, payload)

    @cached_property
    def _index(self) -> dict[MotionKey, int]:
        return {key: k for k, key in enumerate(self.keys)}

    @cached_property
    def _names(self) -> dict[bytes, str]:
        """Names of configurations by their bytes."""
        firsts, lasts = self.waypoints[self.offsets[:-1]], self.waypoints[self.offsets[1:] - 1]
        names = {q.tobytes(): key.start for q, key in zip(firsts, self.keys, strict=True)}
        return names | {q.tobytes(): key.goal for q, key in zip(lasts, self.keys, strict=True)}

    def _motion(self, k: int) -> CoarseMotion:
        path = JointPath(self.joint_names, self.waypoints[self.offsets[k] : self.offsets[k + 1]])
        return CoarseMotion(
            self.keys[k], self.tool_states[k], path, float(self.durations[k]), self._trajectory(k),
            float(self.lower_bounds[k]), float(self.clearances[k]), self.validities[k],
        )  # fmt: skip

    def _trajectory(self, k: int) -> Trajectory | None:
        points = self.points
        if points is None:
            return None
        rows = slice(points.offsets[k], points.offsets[k + 1])
        return Trajectory(
            self.joint_names,
            points.times[rows],
            points.positions[rows],
            points.velocities[rows],
            points.accelerations[rows],
        )


def _offsets(counts: list[int]) -> IntArray:
    return np.concatenate([[0], np.cumsum(counts, dtype=np.int64)]).astype(np.int64)
