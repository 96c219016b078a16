"""The joint space that planners search."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.robot import Robot
from pickcli.geometry import Array

# Distance of a measured start outside a limit (m or rad) that is tolerated: encoders are not exact.
LIMIT_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class JointSpace:
    """The box of configurations, with the velocity and acceleration limits of each joint.

    Attributes:
        joint_names: Names of the n joints.
        lower: (n,) lower position limits, rad or m; infinite for continuous joints, like the upper ones.
        upper: (n,) upper position limits.
        velocity: (n,) limits per s.
        acceleration: (n,) limits per s^2.
    """

    joint_names: tuple[str, ...]
    lower: Array
    upper: Array
    velocity: Array
    acceleration: Array

    @classmethod
    def of(cls, robot: Robot, scale: float = 1.0) -> JointSpace:
        """Build the space of a robot's planned joints.

        Args:
            robot: The robot.
            scale: Factor on velocity and acceleration limits.

        Returns:
            The space.
        """
        limits = robot.limits
        return cls(
            robot.joint_names,
            limits.lower,
            limits.upper,
            limits.velocity * scale,
            limits.acceleration * scale,
        )

    def around(self, Q: Array) -> tuple[Array, Array]:
        """Return finite bounds for a search: the limits, extended to include some configurations.

        Args:
            Q: (N, n) configurations; continuous joints are bounded half a turn beyond them.

        Returns:
            Lower and upper bounds (n,).
        """
        low, high = Q.min(axis=0), Q.max(axis=0)
        lower = np.where(np.isinf(self.lower), low - np.pi, np.minimum(self.lower, low))
        upper = np.where(np.isinf(self.upper), high + np.pi, np.maximum(self.upper, high))
        return lower, upper

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.joint_names)

    def holds(self, q: Array) -> bool:
        """Whether a configuration is finite and within the limits, up to LIMIT_TOLERANCE.

        Args:
            q: (n,) configuration.

        Returns:
            True if it is.
        """
        return bool(self.are_held(np.asarray(q)[None])[0])

    def are_held(self, Q: Array) -> NDArray[np.bool_]:
        """Whether each of many configurations is finite and within the limits, up to LIMIT_TOLERANCE.

        Args:
            Q: (N, n) configurations.

        Returns:
            (N,) True for those that are; False for all if they do not have n joints.
        """
        if Q.shape[1:] != (self.n,):
            return np.zeros(len(Q), dtype=bool)
        is_within = (self.lower - LIMIT_TOLERANCE <= Q) & (self.upper + LIMIT_TOLERANCE >= Q)
        return np.asarray((is_within & np.isfinite(Q)).all(axis=1))
