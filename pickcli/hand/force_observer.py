"""The force with which something pushes a hand, from its motion and the forces of its motors alone.

Source: De Luca and Mattone, "Sensorless robot collision detection and hybrid force/motion control" (ICRA
2005): what changes the momentum beyond the commanded forces comes from outside.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pickcli.geometry import Array

GAIN = 60.0  # 1/s, with which the estimate follows the force


@dataclass
class ForceObserver:
    """The state of a momentum observer of linear motion.

    Attributes:
        mass: kg that moves.
        force: (3,) N, estimate of the force from outside.
    """

    mass: float
    force: Array = field(default_factory=lambda: np.zeros(3))
    _explained: Array = field(default_factory=lambda: np.zeros(3))  # Ns, momentum by known forces

    def advance(self, velocity: Array, commanded: Array, dt: float) -> None:
        """Advance by a step.

        Args:
            velocity: (3,) m/s, measured.
            commanded: (3,) N of the motors beyond what bears the weight, from now on.
            dt: s.
        """
        self.force = GAIN * (self.mass * velocity - self._explained)
        self._explained = self._explained + (commanded + self.force) * dt
