"""What the planners of this room need to know about joints and about being free."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pickcli.cell.robot import Robot
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.kernel import Checker

# A measured start may lie this far outside a limit (m or rad): encoders are no doubles.
LIMIT_TOLERANCE = 1e-6


class EdgeChecker(Protocol):
    """What is free, decided by proof: held item and pivot state are the checker's own affair.

    It may ask for more than the kernel with the margin does: what the kernel finds is proven once more.
    """

    @property
    def kernel(self) -> Checker:
        """The world and the robot in it."""

    @property
    def margin(self) -> float:
        """m that everything must be apart."""

    def is_free(self, q: Array) -> bool:
        """Whether a configuration (n,) keeps the margin."""

    def edge_is_free(self, q0: Array, q1: Array) -> bool:
        """Whether *every* point of the straight edge is proven to keep the margin."""

    def path_is_free(self, Q: Array) -> int:
        """Index of the first edge of a polyline (N, n) that is not proven, -1 if all are."""

    def explain(self, q: Array) -> Reason:
        """Why a configuration is not free."""


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
