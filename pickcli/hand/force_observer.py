"""The forces with which something pushes a hand, from its motion and the forces of its motors alone.

Source: De Luca and Mattone, "Sensorless robot collision detection and hybrid force/motion control" (ICRA
2005): what changes the momentum beyond the known forces comes from outside.
"""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array

GAIN = 60.0  # 1/s, with which the estimate follows the force


class ForceObserver:
    """The state of a momentum observer, which is at rest at first.

    Attributes:
        force: (n,) N or Nm, estimate of what acts from outside.

    Args:
        n: Number of coordinates: axes of the world, or joints.
    """

    def __init__(self, n: int) -> None:
        self.force = np.zeros(n)
        self._explained = np.zeros(n)  # Ns or Nms, momentum by known forces

    def advance(self, momentum: Array, known: Array, dt: float) -> None:
        """Advance by a step.

        Args:
            momentum: (n,) Ns or Nms, by measured velocities.
            known: (n,) N or Nm by which it changes without anything from outside, from now on.
            dt: s.
        """
        self.force = GAIN * (momentum - self._explained)
        self._explained = self._explained + (known + self.force) * dt
