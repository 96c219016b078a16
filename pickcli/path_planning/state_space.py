"""The space of configurations that the planners of this room search."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.robot import Robot
from pickcli.geometry import Array

# A measured start may lie this far outside a limit (m or rad): encoders are no doubles.
LIMIT_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class JointSpace:
    """The box of configurations, and how fast each joint crosses it."""

    joint_names: tuple[str, ...]
    lower: Array  # (n,) m or rad
    upper: Array  # (n,)
    velocity: Array  # (n,) per s
    acceleration: Array  # (n,) per s^2

    @classmethod
    def of(cls, robot: Robot, scale: float = 1.0) -> JointSpace:
        """The space of a robot's planned joints; velocity and acceleration times ``scale``."""
        limits = robot.limits
        return cls(
            robot.joint_names,
            limits.lower,
            limits.upper,
            limits.velocity * scale,
            limits.acceleration * scale,
        )

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.joint_names)

    def holds(self, q: Array) -> bool:
        """Whether a configuration (n,) is finite and within the limits, up to LIMIT_TOLERANCE."""
        return bool(
            np.shape(q) == (self.n,)
            and np.all(np.isfinite(q))
            and np.all(q >= self.lower - LIMIT_TOLERANCE)
            and np.all(q <= self.upper + LIMIT_TOLERANCE)
        )
