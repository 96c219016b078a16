"""Hardest stop: each joint brakes independently with the full torque of its motor.

The set points follow the encoders, so each position loop demands velocity zero and its motor brakes with full
torque until the joint is at rest. Light joints stop long before heavy ones, so the arm leaves the path. In
exchange no joint is driven further into a contact, as it would be if all joints slowed down together along
the path. Afterwards the arm is led back onto its path slowly.
"""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory

OVERSHOOT = 0.5  # s of the path after the start of the stop, within which the robot comes to rest
LOOK_STEP = 1e-3  # s of the path between candidates for the nearest configuration


class Return:
    """Set points from rest beside a trajectory to the trajectory, and then back along it.

    Attributes:
        path_time: s on the trajectory, of the configuration that the robot is led to.

    Args:
        trajectory: The interrupted trajectory.
        path_time: s on the trajectory at the start of the stop.
        q: (n,) configuration at rest.
        duration: s for the return to the path.
    """

    def __init__(self, trajectory: Trajectory, path_time: float, q: Array, duration: float) -> None:
        last = min(path_time + OVERSHOOT, trajectory.duration)
        times = np.linspace(path_time, last, max(2, int(np.ceil((last - path_time) / LOOK_STEP)) + 1))
        off = q - trajectory.sample(times)
        nearest = int(np.argmin(np.abs(off).max(axis=1)))
        self._trajectory, self._off, self._duration, self._t = trajectory, off[nearest], duration, 0.0
        self.path_time = float(times[nearest])

    @property
    def is_on_path(self) -> bool:
        """Whether the robot is on the path again."""
        return self._t >= self._duration

    def advance(self, time_step: float) -> Array:
        """Compute the next set point of a minimum-jerk motion to the path.

        Args:
            time_step: s.

        Returns:
            (n,).
        """
        self._t = min(self._t + time_step, self._duration)
        x = self._t / self._duration
        left = 1.0 - x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
        return np.asarray(self._trajectory.sample(self.path_time)[0] + left * self._off)

    def back(self, time_step: float, rate: float) -> Array:
        """Compute the set point after a step back along the path.

        Args:
            time_step: s.
            rate: Speed as a share of the trajectory's.

        Returns:
            (n,).
        """
        self.path_time = max(0.0, self.path_time - rate * time_step)
        return np.asarray(self._trajectory.sample(self.path_time)[0])
