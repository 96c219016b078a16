"""The database of coarse motions between named configurations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.pod_tolerance import NOMINAL_POD, PodValidity
from pickcli.cell.tool import ToolState
from pickcli.geometry import Array
from pickcli.motion.path import JointPath
from pickcli.motion.trajectory import Trajectory

IntArray = NDArray[np.int64]


class PayloadClass(StrEnum):
    """What a stored motion was proven with; Delft planned all of theirs with a cube attached."""

    EMPTY = "empty"
    CUBE = "cube"  # 0.2 m, one face on the cup
    CENTRED_CUBE = "centred cube"  # 0.2 m, its centre at the tip of the cup: Delft's own


@dataclass(frozen=True)
class MotionKey:
    """Names of the two ends, and the payload class."""

    start: str
    goal: str
    payload: PayloadClass

    def reversed(self) -> MotionKey:
        """The way back."""
        return MotionKey(self.goal, self.start, self.payload)


@dataclass(frozen=True, eq=False)
class CoarseMotion:
    """One stored motion: proven, when it was made, in an empty cell with the cell's clearance.

    tool_state: State of the tool that it is valid for (MOVING covers the others)
    trajectory: None where the timed points were not loaded
    lower_bound: s that no motion between the two ends can undercut
    clearance: m that the motion is proven to keep from everything
    mark: for which pods it is proven
    """

    key: MotionKey
    tool_state: ToolState
    path: JointPath
    duration: float  # s, at full speed
    trajectory: Trajectory | None = None
    lower_bound: float = 0.0
    clearance: float = 0.0
    mark: PodValidity = NOMINAL_POD

    def reversed(self) -> CoarseMotion:
        """The way back: free where the way there is, and within limits as these are symmetric."""
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
    """All trajectories one after the other; motion k owns rows offsets[k]:offsets[k + 1]."""

    times: Array  # (P,) s
    positions: Array  # (P, n)
    velocities: Array  # (P, n)
    accelerations: Array  # (P, n)
    offsets: IntArray  # (K + 1,)


@dataclass(frozen=True, eq=False)
class TrajectoryDatabase:
    """Coarse motions by (start, goal, payload class), flat arrays and offsets. Each is stored once and
    answers in both directions.
    """

    joint_names: tuple[str, ...]
    keys: tuple[MotionKey, ...]  # (K,)
    tool_states: tuple[ToolState, ...]  # (K,)
    durations: Array  # (K,) s
    waypoints: Array  # (W, n)
    offsets: IntArray  # (K + 1,) into waypoints
    lower_bounds: Array  # (K,) s
    clearances: Array  # (K,) m
    marks: tuple[PodValidity, ...]  # (K,)
    points: TimedPoints | None = None

    @classmethod
    def of(cls, joint_names: tuple[str, ...], motions: list[CoarseMotion]) -> TrajectoryDatabase:
        """A database of timed motions."""
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
            tuple(motion.mark for motion in motions),
            points,
        )

    def __len__(self) -> int:
        return len(self.keys)

    def __iter__(self) -> Iterator[CoarseMotion]:
        return (self._motion(k) for k in range(len(self)))

    def lookup(self, start: str, goal: str, payload: PayloadClass) -> CoarseMotion | None:
        """The motion between two named configurations, turned round if need be, or None.

        The caller proves it again in the scene as it is.
        """
        key = MotionKey(start, goal, payload)
        if key in self._index:
            return self._motion(self._index[key])
        if key.reversed() in self._index:
            return self._motion(self._index[key.reversed()]).reversed()
        return None

    def between(self, q_start: Array, q_goal: Array, payload: PayloadClass) -> CoarseMotion | None:
        """Like ``lookup``, for two configurations (n,) that are exactly those of stored ends."""
        start, goal = (self._names.get(np.asarray(q, dtype=float).tobytes()) for q in (q_start, q_goal))
        return None if start is None or goal is None else self.lookup(start, goal, payload)

    @cached_property
    def _index(self) -> dict[MotionKey, int]:
        return {key: k for k, key in enumerate(self.keys)}

    @cached_property
    def _names(self) -> dict[bytes, str]:
        """Name by the bytes of its configuration."""
        firsts, lasts = self.waypoints[self.offsets[:-1]], self.waypoints[self.offsets[1:] - 1]
        names = {q.tobytes(): key.start for q, key in zip(firsts, self.keys, strict=True)}
        return names | {q.tobytes(): key.goal for q, key in zip(lasts, self.keys, strict=True)}

    def _motion(self, k: int) -> CoarseMotion:
        path = JointPath(self.joint_names, self.waypoints[self.offsets[k] : self.offsets[k + 1]])
        return CoarseMotion(
            self.keys[k], self.tool_states[k], path, float(self.durations[k]), self._trajectory(k),
            float(self.lower_bounds[k]), float(self.clearances[k]), self.marks[k],
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
