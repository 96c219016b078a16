"""The hardest stop there is: every joint by itself, with all the torque that its motor has.

Set points follow the encoders. A position loop that is told to stay where it is asks for velocity zero, and
the motor brakes with all its torque until the joint stands. Light joints stand long before heavy ones, so the
path is left by what lies between. In exchange no joint is driven on into what is touched, as it is where all
must slow down together along the path. Afterwards the arm is led back onto its path, gently.
"""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory

OVERSHOOT = 0.5  # s of the path beyond where the stop began in which the robot can have come to rest
LOOK_STEP = 1e-3  # s of the path between the configurations of which the nearest is looked for


class Return:
    """Set points from rest beside a trajectory onto it and back along it.

    Attributes:
        path_time: s on the trajectory, of the configuration on it that the robot is led to.

    Args:
        trajectory: What was being carried out.
        path_time: s on it where the stop began.
        q: (n,) where the robot stands.
        duration: s in which the distance to the path is closed.
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
        """Whether the distance to the path is closed."""
        return self._t >= self._duration

    def advance(self, time_step: float) -> Array:
        """The next set point, closer to the path: a minimum-jerk blend from rest to rest.

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
        """The set point after a step back along the path.

        Args:
            time_step: s.
            rate: Share of the path's pace.

        Returns:
            (n,).
        """
        self.path_time = max(0.0, self.path_time - rate * time_step)
        return np.asarray(self._trajectory.sample(self.path_time)[0])
