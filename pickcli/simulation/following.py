"""Following errors of a robot's joints."""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.simulation.thresholds import Thresholds

SPEED_MEMORY = 0.1  # s, time constant with which the allowance for a joint's speed decays


class JointFollowing:
    """Compares set points with measured joint positions.

    Args:
        q: (n,) initial set point.
        time_step: s between set points.
        thresholds: Allowed errors; by default those of supervision.

    Attributes:
        speed: (n,) speed of the set points, as a decaying maximum over about 0.1 s.
    """

    def __init__(self, q: Array, time_step: float, thresholds: Thresholds | None = None) -> None:
        self._command, self._time_step = q, time_step
        self._thresholds = thresholds or Thresholds()
        self._decay = float(np.exp(-time_step / SPEED_MEMORY))
        self.speed: Array = np.zeros(len(q))

    def remember(self, command: Array) -> None:
        """Update the set point; call after its step.

        Args:
            command: (n,) configuration.
        """
        now = np.abs(command - self._command) / self._time_step
        self.speed, self._command = np.maximum(now, self._decay * self.speed), command

    def worst(self, q: Array) -> tuple[int, float, float] | None:
        """Find the joint with the largest following error.

        Args:
            q: (n,) measured configuration.

        Returns:
            Its index, error and allowed error; None if all joints follow.
        """
        error = np.abs(self._command - q)
        allowed = self._thresholds.joint + self._thresholds.lag * self.speed
        joint = int((error / allowed).argmax())
        if error[joint] <= allowed[joint]:
            return None
        return joint, float(error[joint]), float(allowed[joint])
