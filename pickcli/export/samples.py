"""Samples of a motion at integer nanoseconds since its start, which every format can represent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.errors import InputError
from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory

SECOND = 1_000_000_000  # ns
MIN_RATE, MAX_RATE = 1.0, 1000.0  # Hz
SAMPLE_TIME = 1e-3  # s between samples for interpolation errors


@dataclass(frozen=True, eq=False)
class MotionSamples:
    """Sampled states of a motion.

    Attributes:
        nanoseconds: (K,) since the start, from 0 to the end, strictly increasing.
        positions: (K, n) rad or m.
        velocities: (K, n) per s, zero at both ends.
        accelerations: (K, n) per s^2.
    """

    nanoseconds: NDArray[np.int64]
    positions: Array
    velocities: Array
    accelerations: Array

    def as_trajectory(self, joint_names: tuple[str, ...]) -> Trajectory:
        """Return the motion of a controller that interpolates the samples by quintics.

        Args:
            joint_names: Names of the n joints.

        Returns:
            The motion.
        """
        return Trajectory(
            joint_names, self.nanoseconds / SECOND, self.positions, self.velocities, self.accelerations
        )


def to_nanoseconds(t: float) -> int:
    """Convert a time to integer nanoseconds.

    Args:
        t: s; negative rounding errors count as 0.

    Returns:
        ns.
    """
    return max(0, round(t * SECOND))


def stamp(nanoseconds: int) -> dict[str, int]:
    """Convert a time or duration to the representation of ROS 2.

    Args:
        nanoseconds: At least 0.

    Returns:
        ``sec`` and ``nanosec``.
    """
    sec, nanosec = divmod(int(nanoseconds), SECOND)
    return {"sec": sec, "nanosec": nanosec}


def sampled(trajectory: Trajectory, rate: float | None) -> MotionSamples:
    """Sample a motion.

    Args:
        trajectory: The motion.
        rate: Hz; None for the trajectory's own points, with points in the same nanosecond merged.

    Returns:
        The samples. The last one is the trajectory's last point; at a given rate, the last interval is
        half to one and a half periods long.

    Raises:
        InputError: The rate is out of range.
    """
    if rate is None:
        return _own_points(trajectory)
    if not MIN_RATE <= rate <= MAX_RATE:
        raise InputError(f"rate: {rate:g} Hz is not between {MIN_RATE:g} and {MAX_RATE:g}; name one that is")
    n_periods = max(0, int(np.floor(trajectory.duration * rate - 0.5)))
    nanoseconds = np.rint(np.arange(n_periods + 1) * (SECOND / rate)).astype(np.int64)
    end = to_nanoseconds(trajectory.duration)
    nanoseconds = nanoseconds[nanoseconds < end]  # none if the motion ends within its first nanosecond
    states = trajectory.states(nanoseconds / SECOND)
    last = (trajectory.positions[-1:], trajectory.velocities[-1:], trajectory.accelerations[-1:])
    return MotionSamples(
        np.append(nanoseconds, end),
        *(np.concatenate(pair) for pair in zip(states, last, strict=True)),
    )


def _own_points(trajectory: Trajectory) -> MotionSamples:
    nanoseconds = np.rint(trajectory.times * SECOND).astype(np.int64)
    # Of points in the same nanosecond the first is kept, but at the end the last.
    kept = np.flatnonzero(np.diff(nanoseconds, prepend=-1))
    if nanoseconds[kept[-1]] == nanoseconds[-1]:
        kept[-1] = len(nanoseconds) - 1
    return MotionSamples(
        nanoseconds[kept],
        trajectory.positions[kept],
        trajectory.velocities[kept],
        trajectory.accelerations[kept],
    )


def interpolation_error(trajectory: Trajectory, samples: MotionSamples) -> tuple[float, int]:
    """Compute the deviation of a controller that interpolates the samples by quintics.

    Args:
        trajectory: The motion.
        samples: Samples of the motion, at least two.

    Returns:
        The largest joint deviation over all milliseconds (rad or m), and the joint's index.
    """
    times = np.arange(0.0, trajectory.duration, SAMPLE_TIME)
    followed = samples.as_trajectory(trajectory.joint_names).sample(times)
    worst = np.abs(followed - trajectory.sample(times)).max(axis=0)
    return float(worst.max()), int(worst.argmax())
