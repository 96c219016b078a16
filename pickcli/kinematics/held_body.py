"""A rigid body in the cup: the wrench that moves it, by the equations of Newton and Euler."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.geometry import GRAVITY, Array, skew
from pickcli.kinematics.tip_motion import TipMotion


@dataclass(frozen=True, eq=False)
class HeldBody:
    """A body fixed to the tool frame.

    Attributes:
        mass: kg.
        p_tip_com: (3,) centre of mass in the tool frame, m.
        inertia: (3, 3) about the centre of mass, in the axes of the tool frame, kg m^2.
    """

    mass: float
    p_tip_com: Array
    inertia: Array

    def wrench(self, motion: TipMotion, gravity: float = GRAVITY) -> Array:
        """Compute the wrench of the tool on the body in every state of a motion.

        Args:
            motion: N states of the tool frame.
            gravity: m/s^2.

        Returns:
            (N, 6) force in N, then torque about the tip in Nm, both in the axes of the tool frame.
        """
        R = motion.poses[:, :3, :3]
        omega, alpha = _in_tip(R, motion.angular_velocity), _in_tip(R, motion.angular_acceleration)
        upwards = _in_tip(R, motion.acceleration + np.array([0.0, 0.0, gravity]))
        S = skew(self.p_tip_com)
        # x @ S = -(S x), because vectors are rows here.
        of_com = upwards + alpha @ S + _cross(omega, omega @ S)
        force = self.mass * of_com
        spin = alpha @ self.inertia + _cross(omega, omega @ self.inertia)
        return np.concatenate([force, spin - force @ S], axis=1)

    def weight(self, R_world_tip: Array) -> Array:
        """Compute the wrench of the tool on the body at rest.

        Args:
            R_world_tip: (N, 3, 3) orientations of the tool frame.

        Returns:
            (N, 6) force in N, then torque about the tip in Nm, both in the axes of the tool frame.
        """
        force = self.mass * GRAVITY * R_world_tip[:, 2]
        return np.concatenate([force, -force @ skew(self.p_tip_com)], axis=1)

    def path_wrench(self, motion: TipMotion) -> tuple[Array, Array, Array]:
        """Compute the wrench along a path as a u + b x + c (path acceleration u, squared path velocity x).

        Like accelerations and products of velocities, it is linear in both: u = d2s/dt2, x = (ds/dt)^2.

        Args:
            motion: Motion of the tool frame with derivatives by the path's parameter s, from dq/ds and
                d2q/ds2.

        Returns:
            a, b and c, each (N, 6); c is the wrench at rest.
        """
        zero = np.zeros_like(motion.velocity)
        by_u = TipMotion(motion.poses, zero, zero, motion.velocity, motion.angular_velocity)
        return self.wrench(by_u, 0.0), self.wrench(motion, 0.0), self.wrench(motion.at_rest())


def _in_tip(R_world_tip: Array, vectors: Array) -> Array:
    """Rotate world vectors (N, 3) into the tool frame."""
    return np.asarray(np.matmul(vectors[:, None, :], R_world_tip)[:, 0])


def _cross(a: Array, b: Array) -> Array:
    """Return cross products (N, 3), row by row."""
    return np.stack([a[:, i] * b[:, j] - a[:, j] * b[:, i] for i, j in ((1, 2), (2, 0), (0, 1))], axis=1)
