"""State sampling: states of a motion that are so dense that no point moves far between two of them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.robot import Robot
from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory
from pickcli.verification.forward_kinematics import link_poses
from pickcli.verification.quintic import motion, variation

MAX_STEP = 0.002  # m, farthest that any point of robot or held item moves between two states
MAX_STATES = 100_000
NEIGHBOURS = 16  # intervals that are split together: those next to one that has to be split are split, too


@dataclass(frozen=True, eq=False)
class States:
    """Times, configurations and link poses, and how far the joints travelled up to each."""

    times: Array  # (N,) s
    Q: Array  # (N, n)
    links: Array  # (L, N, 4, 4)
    travel: Array  # (N, n) rad or m, an upper bound of each joint's travel since the first of them
    max_step: float  # m, largest step between two states
    robot: Robot
    trajectory: Trajectory
    _finer: dict[tuple[int, int], States] = field(default_factory=dict, repr=False)

    def between(self, t_start: float, t_end: float) -> tuple[int, int]:
        """Return the indices of the states at two times, which must be times of states (segment ends are).

        Args:
            t_start: s.
            t_end: s.

        Returns:
            Indices of both.
        """
        i, j = np.searchsorted(self.times, (t_start - 1e-9, t_end - 1e-9))
        return int(i), int(min(j, len(self.times) - 1))

    def finer(self, i: int, n: int) -> States:
        """Split the interval from a state to the next one into equal parts.

        Args:
            i: Index of the state.
            n: Number of parts.

        Returns:
            The states.
        """
        if (i, n) not in self._finer:
            first = i - i % NEIGHBOURS
            block = self.times[first : first + NEIGHBOURS + 1]
            starts, ends = block[:-1], block[1:]
            times = np.append(np.linspace(starts, ends, n, endpoint=False, axis=1).ravel(), ends[-1])
            split = _states_at(times, self.robot, self.trajectory, self.max_step)
            for k in range(len(starts)):
                self._finer[first + k, n] = split.part(k * n, (k + 1) * n)
        return self._finer[i, n]

    def part(self, i: int, j: int) -> States:
        """Return the states from one to another.

        Args:
            i: Index of the first state.
            j: Index of the last.

        Returns:
            The states.
        """
        k = slice(i, j + 1)
        travel = self.travel[k] - self.travel[i]
        return States(
            self.times[k], self.Q[k], self.links[:, k], travel, self.max_step, self.robot, self.trajectory
        )


def sample_states(robot: Robot, trajectory: Trajectory, also: Array, reach: Array) -> States:
    """Split a trajectory until no point moves more than MAX_STEP between two states, or there are too many.

    Args:
        robot: The robot.
        trajectory: The trajectory.
        also: (K,) s that must be among the states' times.
        reach: (n,) m per unit of each joint, of the part that reaches farthest.

    Returns:
        The states; their ``max_step`` is above MAX_STEP if more than MAX_STATES would be needed.
    """
    times = merged(np.concatenate([trajectory.times, also]))
    while True:
        way = variation(*motion(trajectory, times), times)
        steps = way @ reach
        if not np.ceil(steps / MAX_STEP).sum() <= MAX_STATES:  # before they are integers, which overflow
            break
        n = np.ceil(steps / MAX_STEP).astype(np.int64)
        if n.max() <= 1:
            break
        times = np.concatenate([_split(times, np.maximum(n, 1)), times[-1:]])
    return _states_at(times, robot, trajectory, float(steps.max()))


def _states_at(times: Array, robot: Robot, trajectory: Trajectory, max_step: float) -> States:
    p, v, a = motion(trajectory, times)
    way = variation(p, v, a, times)
    travel = np.concatenate([np.zeros((1, p.shape[1])), np.cumsum(way, axis=0)])
    return States(times, p, link_poses(robot, p), travel, max_step, robot, trajectory)


def merged(times: Array) -> Array:
    """Sort times and drop repetitions closer than a nanosecond; the first of each is kept.

    Args:
        times: (N,) s.

    Returns:
        (M,) s.
    """
    times = np.sort(times)
    keep = np.concatenate([[True], np.diff(times) > 1e-9])
    return np.asarray(times[keep])


def _split(times: Array, n: NDArray[np.int64]) -> Array:
    """Cut every interval between two times into n equal parts; return the starts of the parts."""
    start, h = np.repeat(times[:-1], n), np.repeat(np.diff(times) / n, n)
    k = np.arange(n.sum()) - np.repeat(np.cumsum(n) - n, n)
    return np.asarray(start + k * h)
