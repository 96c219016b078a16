"""The impedance of the wrist: tau = K (q_d - q) - D dq + gravity, and the torque at which the arm stops."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pickcli.geometry import Array
from pickcli.hand.belt_hand import Wrist
from pickcli.hand.force_observer import ForceObserver


@dataclass
class WristImpedance:
    """The state of the impedance control.

    Attributes:
        wrist: Its figures.
        mass: kg of all that the wrist bears.
        wanted: (6,) m and rad: x, y, z, yaw, pitch, roll.
        is_level_soft: Whether it is soft in the horizontal plane.
        stretched: (6,) N and Nm with which the spring and the damper act in the last step.
        measured: (6,) m and rad, as ``wanted``, in the last step.
    """

    wrist: Wrist
    mass: float
    wanted: Array
    is_level_soft: bool = False
    stretched: Array = field(default_factory=lambda: np.zeros(6))
    measured: Array = field(init=False)

    def __post_init__(self) -> None:
        self.measured, self._observer = self.wanted.copy(), ForceObserver(3)

    @property
    def felt(self) -> Array:
        """(3,) N with which something pushes the hand, estimated from encoders and torques."""
        return self._observer.force

    @property
    def stiffness(self) -> Array:
        """(6,) N/m and Nm/rad."""
        wrist = self.wrist
        level = wrist.level if self.is_level_soft else wrist.stiff
        return np.array([level, level, wrist.stiff, *[wrist.turning] * 3])

    def efforts(self, q: Array, dq: Array, gravity: Array, dt: float) -> Array:
        """Compute the efforts of the wrist's joints for a step.

        Args:
            q: (6,) m and rad.
            dq: (6,) m/s and rad/s.
            gravity: (6,) N and Nm that bear the hand.
            dt: s of the step.

        Returns:
            (6,) N and Nm.
        """
        K = self.stiffness
        borne = np.array([self.mass] * 3 + [self.wrist.inertia] * 3)
        D = 2.0 * self.wrist.damping * np.sqrt(K * borne)
        self.stretched = K * (self.wanted - q) - D * dq
        self.measured = q.copy()
        self._observer.advance(self.mass * dq[:3], self.stretched[:3], dt)
        return np.asarray(self.stretched + gravity)

    @property
    def is_overloaded(self) -> bool:
        """Whether any torque or force is beyond its threshold."""
        linear, angular = np.abs(self.stretched[:3]).max(), np.abs(self.stretched[3:]).max()
        return bool(linear > self.wrist.most_force or angular > self.wrist.most_torque)

    @property
    def lifting(self) -> float:
        """N upwards with which it bears what the hand holds."""
        return float(self.stretched[2])
