"""Whether the joints of a robot follow their set points."""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.simulation.thresholds import Thresholds

SPEED_MEMORY = 0.1  # s that a joint's speed still excuses its lag after it has slowed down


class JointFollowing:
    """Compares set points with where the joints are.

    Args:
        q: (n,) set point to begin with.
        time_step: s between set points.
        thresholds: How far a joint may be off; those of supervision if None.

    Attributes:
        speed: (n,) of the set points; of the past 0.1 s the greatest, fading.
    """

    def __init__(self, q: Array, time_step: float, thresholds: Thresholds | None = None) -> None:
        self._command, self._time_step = q, time_step
        self._thresholds = thresholds or Thresholds()
        self._decay = float(np.exp(-time_step / SPEED_MEMORY))
        self.speed: Array = np.zeros(len(q))

    def remember(self, command: Array) -> None:
        """Take a set point; after its step.

        Args:
            command: (n,) configuration.
        """
        now = np.abs(command - self._command) / self._time_step
        self.speed, self._command = np.maximum(now, self._decay * self.speed), command

    def worst(self, q: Array) -> tuple[int, float, float] | None:
        """The joint that is farthest off.

        Args:
            q: (n,) measured configuration.

        Returns:
            Its index, how far it is off and how far it may be; None where all follow.
        """
        error = np.abs(self._command - q)
        allowed = self._thresholds.joint + self._thresholds.lag * self.speed
        joint = int((error / allowed).argmax())
        if error[joint] <= allowed[joint]:
            return None
        return joint, float(error[joint]), float(allowed[joint])
