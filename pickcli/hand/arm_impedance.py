"""Cartesian impedance of an arm at the hand: tau = J^T (K (x_d - x) - D dx) + gravity, by torque control.

Source: Hogan, "Impedance control", 1985; of the wrist that gives way in the horizontal plane: Krug et al.
(RA-L 2016, section III-C).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.geometry import Array, rotation_rpy, rotation_vector, to_rpy
from pickcli.hand.belt_hand import Wrist

IDLE_DAMPING = 4.0  # Nms/rad of joint motion that does not move the hand
LIMIT_ROOM = 0.05  # rad before the limit of a joint, from where on it is pushed back
LIMIT_STIFFNESS = 800.0  # Nm/rad with which it is
LIMIT_DAMPING = 0.7  # of the critical damping by its own inertia


@dataclass
class ArmImpedance:
    """The state of the impedance control.

    Attributes:
        wrist: Its figures.
        mass: kg with which the damping is critical.
        wanted: (6,) m and rad of the hand in the world: x, y, z, yaw, pitch, roll.
        is_level_soft: Whether it is soft in the horizontal plane.
        stretched: (6,) N and Nm with which spring and damper act on the hand, along and about the axes of the
            world, in the last step.
        measured: (6,) m and rad, as ``wanted``, in the last step.
        felt: (3,) N with which something pushes the hand, estimated from encoders and torques.
        is_leading: Whether it exerts what the motion of the wanted pose needs, so that the hand does not lag
            behind; else only what it lags.
    """

    wrist: Wrist
    mass: float
    wanted: Array = field(default_factory=lambda: np.zeros(6))
    is_level_soft: bool = False
    stretched: Array = field(default_factory=lambda: np.zeros(6))
    measured: Array = field(default_factory=lambda: np.zeros(6))
    felt: Array = field(default_factory=lambda: np.zeros(3))
    is_leading: bool = False
    _before: Array = field(default_factory=lambda: np.zeros(3))  # m, wanted in the last step
    _rate: Array = field(default_factory=lambda: np.zeros(3))  # m/s of what is wanted, while it leads

    def hold(self, T_world_hand: Array) -> None:
        """Want a pose from now on, stiff in all directions.

        Args:
            T_world_hand: (4, 4).
        """
        self.wanted = wrist_position(T_world_hand)
        self.measured, self._before, self._rate = self.wanted.copy(), self.wanted[:3].copy(), np.zeros(3)
        self.is_level_soft = self.is_leading = False

    def lead(self, jacobian: Array, mass_matrix: Array, dt: float) -> Array:
        """Compute the efforts that accelerate the hand as the wanted position is, and note its rate.

        Called once a step, before ``efforts``. The inertia at the hand is (J M^-1 J^T)^-1 (Khatib 1987).

        Args:
            jacobian: (6, n) of the hand.
            mass_matrix: (n, n) kg m^2 of the joints.
            dt: s of a step.

        Returns:
            (n,) Nm, zero unless it is leading.
        """
        rate = (self.wanted[:3] - self._before) / dt if self.is_leading else np.zeros(3)
        acceleration = np.append((rate - self._rate) / dt, np.zeros(3))
        self._before, self._rate = self.wanted[:3].copy(), rate
        if not self.is_leading:
            return np.zeros(len(mass_matrix))
        inertia = np.linalg.inv(jacobian @ np.linalg.solve(mass_matrix, jacobian.T))
        return np.asarray(jacobian.T @ inertia @ acceleration)

    def efforts(self, T_world_hand: Array, jacobian: Array, dq: Array, gravity: Array) -> Array:
        """Compute the efforts of the arm's joints.

        Args:
            T_world_hand: (4, 4) pose of the hand.
            jacobian: (6, n) of the hand's frame in axes of the world: m/s, then rad/s.
            dq: (n,) rad/s.
            gravity: (n,) Nm that bear arm and hand.

        Returns:
            (n,) Nm.
        """
        wrist = self.wrist
        level = wrist.level if self.is_level_soft else wrist.stiff
        K = np.array([level, level, wrist.stiff, *[wrist.turning] * 3])
        D = 2.0 * wrist.damping * np.sqrt(K * np.array([self.mass] * 3 + [wrist.inertia] * 3))
        yaw, pitch, roll = self.wanted[3:]
        turn = rotation_vector(rotation_rpy(roll, pitch, yaw) @ T_world_hand[:3, :3].T)
        off = np.concatenate([self.wanted[:3] - T_world_hand[:3, 3], turn])
        self.stretched = K * off - D * (jacobian @ dq - np.append(self._rate, np.zeros(3)))
        self.measured = wrist_position(T_world_hand)
        idle = dq - np.linalg.pinv(jacobian) @ (jacobian @ dq)
        return np.asarray(jacobian.T @ self.stretched - IDLE_DAMPING * idle + gravity)

    @property
    def is_overloaded(self) -> bool:
        """Whether any force or torque is beyond its threshold."""
        linear, angular = np.abs(self.stretched[:3]).max(), np.abs(self.stretched[3:]).max()
        return bool(linear > self.wrist.most_force or angular > self.wrist.most_torque)

    @property
    def lifting(self) -> float:
        """N upwards with which it bears what the hand holds."""
        return float(self.stretched[2])


def wrist_position(T_world_hand: Array) -> Array:
    """Return a pose as the position of a wrist.

    Args:
        T_world_hand: (4, 4).

    Returns:
        (6,) m and rad: x, y, z, yaw, pitch, roll.
    """
    return np.concatenate([T_world_hand[:3, 3], to_rpy(T_world_hand[:3, :3])[::-1]])


def limit_efforts(limits: Limits, q: Array, dq: Array, inertia: Array) -> Array:
    """Compute efforts that push joints back from their limits, by a spring and damper before each limit.

    The impedance at the hand leaves an arm with more than six joints free to move; nothing else keeps that
    motion within the limits.

    Args:
        limits: Of the joints.
        q: (n,) rad.
        dq: (n,) rad/s.
        inertia: (n,) kg m^2 that each joint moves.

    Returns:
        (n,) Nm, zero for joints farther than ``LIMIT_ROOM`` from their limits.
    """
    below = np.maximum(limits.lower + LIMIT_ROOM - q, 0.0)
    above = np.maximum(q - limits.upper + LIMIT_ROOM, 0.0)
    damping = 2.0 * LIMIT_DAMPING * np.sqrt(LIMIT_STIFFNESS * inertia)
    return np.asarray(LIMIT_STIFFNESS * (below - above) - damping * dq * (below + above > 0.0))
