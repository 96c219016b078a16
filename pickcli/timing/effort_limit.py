"""The efforts of the motors as a path constraint: what their torques and forces leave for the motion.

By the equations of motion the efforts along a path are a u + b x + c, linear in path acceleration u and
squared path velocity x, with c at rest (``ArmDynamics.path_efforts``): two half-planes for each joint, as in
Pham and Pham, "A New Approach to Time-Optimal Path Parameterization Based on Reachability Analysis", IEEE
T-RO 34(3), 2018, section II.B.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.geometry import Array
from pickcli.kinematics.arm_dynamics import ArmDynamics
from pickcli.motion.trajectory import Trajectory
from pickcli.timing.path_constraint import HalfPlanes
from pickcli.timing.trajectory_sampling import states_at

STEP = 0.002  # s between the states of a motion at which its efforts are computed
MIN_SHARE = 1e-3  # share of the limits that the half-planes leave at least, if the weight takes up nearly all


@dataclass(frozen=True, eq=False)
class EffortLimit:
    """Limit of the efforts of the motors while the arm moves.

    Attributes:
        dynamics: Inverse dynamics of the arm with what it holds.
        most: (n,) largest usable effort of each motor, N or Nm.
    """

    dynamics: ArmDynamics
    most: Array

    def __str__(self) -> str:
        return "what the motors may exert"

    def broken_at_rest(self, q: Array) -> str:
        """Say which motor is too weak to bear the arm at rest (see ``PathConstraint``).

        Args:
            q: (n,) configuration.

        Returns:
            The limit and the motor that lacks most.
        """
        rest = np.zeros((1, len(q)))
        needed = np.abs(self.dynamics.efforts(q[None], rest, rest)[0])
        j = int(np.argmax(needed / self.most))
        unit = self.dynamics.units[j]
        return f"{self}: {self.dynamics.joints[j]} needs {needed[j]:.4g} of {self.most[j]:.4g} {unit}"

    def is_kept(self, trajectory: Trajectory) -> bool:
        """Whether the efforts during a motion keep the limits, at states at most ``STEP`` apart.

        Args:
            trajectory: The motion.

        Returns:
            True if they do.
        """
        n = int(np.ceil(trajectory.duration / STEP)) + 1
        states = states_at(trajectory, np.linspace(0.0, trajectory.duration, n))
        return bool((np.abs(self.dynamics.efforts(*states)) <= self.most).all())

    def half_planes(self, q: Array, dq: Array, ddq: Array) -> HalfPlanes:
        """Compute two half-planes for the effort of each joint (see ``PathConstraint``).

        Args:
            q: (M, n) configurations.
            dq: (M, n) dq/ds.
            ddq: (M, n) d2q/ds2.

        Returns:
            The half-planes that keep the efforts within the limits.
        """
        a, b, c = (effort / self.most for effort in self.dynamics.path_efforts(q, dq, ddq))
        left = np.maximum(np.hstack([1.0 - c, 1.0 + c]), MIN_SHARE)
        return HalfPlanes(np.hstack([a, -a]), np.hstack([b, -b]), left)

    def time_scale(self, q: Array, velocity: Array, acceleration: Array) -> Array:
        """Return the factor of time at which the efforts keep the limits (see ``PathConstraint``).

        The efforts in excess of those at rest fall with the square of time.

        Args:
            q: (M, n) configurations.
            velocity: (M, n) per s.
            acceleration: (M, n) per s^2.

        Returns:
            (M,) at least 1; inf if not even rest keeps the limits.
        """
        factor = np.ones(len(q))
        moving = self.dynamics.efforts(q, velocity, acceleration) / self.most
        over = np.flatnonzero(np.abs(moving).max(axis=1) > 1.0)
        if len(over) == 0:
            return factor
        zero = np.zeros_like(q[over])
        resting = self.dynamics.efforts(q[over], zero, zero) / self.most
        extra = moving[over] - resting
        room = np.maximum(np.where(extra > 0.0, 1.0 - resting, 1.0 + resting), 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            shares = np.where(extra == 0.0, 1.0, room / np.abs(extra)).min(axis=1)
            shares = np.where(np.abs(resting).max(axis=1) > 1.0, 0.0, np.minimum(shares, 1.0))
            factor[over] = 1.0 / np.sqrt(shares)
        return factor
