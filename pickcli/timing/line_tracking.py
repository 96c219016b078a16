"""The motion of a linear axis along a running conveyor, added to a motion that is planned as if it stood.

The axis follows the belt by an offset: 0 until the motion starts, then it comes up to the belt's speed, keeps
it while the tool works on the item, and comes to rest again. Position, velocity and acceleration of the
offset are continuous, so that added to a trajectory, whose points lie where its parts begin, it gives exactly
the sum of both.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory

RAMP_PIECES = 8  # of a trajectory, in each ramp
MOST_PACE = 1.05  # of the time of a plan that catches up with the belt: its lines have room for that
BACK = 0.85  # of the pace of lines, at which they are gone back: a short way leaves no room to slow down
SAME_TIME = 1e-6  # s: nearer points are one


def ramp_time(speed: float, acceleration: float, jerk: float) -> float:
    """Compute how long an axis takes from rest to a speed; it takes as long back to rest.

    The velocity follows the smoothstep 3 s^2 - 2 s^3, a cubic, so that the position is a quartic, which the
    quintics of a trajectory meet exactly. Its acceleration is at most 1.5 speed / T, its jerk 6 speed / T^2,
    and it covers half of what the speed would cover in the time.

    Args:
        speed: m/s.
        acceleration: m/s^2, of the axis at most.
        jerk: m/s^3, at most.

    Returns:
        s.
    """
    return float(max(1.5 * speed / acceleration, (6.0 * speed / jerk) ** 0.5))


@dataclass(frozen=True)
class TrackedMotion:
    """The offset of the axis that follows a belt.

    Attributes:
        axis: Index of the joint.
        speed: m/s of the axis, negative against its direction.
        t_start: s at which it begins to move.
        t_synchronous: s from which it has the speed.
        t_leaving: s until which it keeps it.
        t_end: s at which it is at rest again.
    """

    axis: int
    speed: float
    t_start: float
    t_synchronous: float
    t_leaving: float
    t_end: float

    def offset(self, t: Array) -> tuple[Array, Array, Array]:
        """Compute the offset and its derivatives.

        Args:
            t: (N,) s.

        Returns:
            (N,) m, (N,) m/s and (N,) m/s^2.
        """
        v = self.speed
        up, down = self.t_synchronous - self.t_start, self.t_end - self.t_leaving
        rising = np.clip((t - self.t_start) / up, 0.0, 1.0)
        falling = np.clip((self.t_end - t) / down, 0.0, 1.0)
        along = np.clip(t, self.t_synchronous, self.t_leaving) - self.t_synchronous
        positions = v * (up * _covered(rising) + along + down * (0.5 - _covered(falling)))
        share = np.where(t < self.t_leaving, rising, falling)
        slope = np.where(t < self.t_leaving, 1.0 / up, -1.0 / down)
        velocities = v * share**2 * (3.0 - 2.0 * share)
        return positions, velocities, v * slope * 6.0 * share * (1.0 - share)

    def added_to(self, trajectory: Trajectory) -> Trajectory:
        """Add the offset to a trajectory in which the axis does not follow the belt.

        Args:
            trajectory: The trajectory, which may move or rest during the ramps.

        Returns:
            The sum, with further points in the ramps.
        """
        ramps = ((self.t_start, self.t_synchronous), (self.t_leaving, self.t_end))
        more = np.concatenate([np.linspace(*ramp, RAMP_PIECES + 1) for ramp in ramps])
        is_new = np.abs(more[:, None] - trajectory.times).min(axis=1) > SAME_TIME
        t = np.sort(np.concatenate([trajectory.times, more[is_new]]))
        rows = trajectory.states(t)
        # The given points as they are: an interpolated one differs by its rounding.
        given = np.searchsorted(t, trajectory.times)
        for row, own in zip(
            rows, (trajectory.positions, trajectory.velocities, trajectory.accelerations), strict=True
        ):
            row[given] = own
        for row, added in zip(rows, self.offset(t), strict=True):
            row[:, self.axis] += added
        return Trajectory(trajectory.joint_names, t, *rows)


def _covered(share: Array) -> Array:
    """Share of speed times duration that a rising ramp has covered at a share (N,) of its duration."""
    return np.asarray(share**3 - 0.5 * share**4)


def relative_to_belt(trajectory: Trajectory, axis: int, speed: float, t_origin: float) -> Trajectory:
    """Express a trajectory relative to a belt that runs along one of its axes.

    Args:
        trajectory: The motion in the hall.
        axis: Index of the axis along which the belt runs.
        speed: m/s of the belt, negative against the axis.
        t_origin: s at which the two frames coincide.

    Returns:
        The motion as seen from the belt.
    """
    positions, velocities = trajectory.positions.copy(), trajectory.velocities.copy()
    positions[:, axis] -= speed * (trajectory.times - t_origin)
    velocities[:, axis] -= speed
    return replace(trajectory, positions=positions, velocities=velocities)


def shifted(trajectory: Trajectory, axis: int, by: float) -> Trajectory:
    """Shift a trajectory along one of its axes.

    Args:
        trajectory: The motion.
        axis: Index of the axis.
        by: m.

    Returns:
        The shifted motion.
    """
    positions = trajectory.positions.copy()
    positions[:, axis] += by
    return replace(trajectory, positions=positions)
