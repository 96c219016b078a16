"""Inverse dynamics of an arm: the efforts of its motors, with what the tool holds."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from pickcli.cell.inertial import Inertial
from pickcli.cell.tool import ToolState
from pickcli.geometry import GRAVITY, Array
from pickcli.kinematics.arm import Arm
from pickcli.kinematics.held_body import HeldBody


class ArmDynamics:
    """The rigid links of an arm in one tool state, moved by its joints without friction.

    Args:
        arm: Kinematics of the arm.
        tool_state: State of the tool; its joint is at rest.
        held: What the tool holds.
    """

    def __init__(self, arm: Arm, tool_state: ToolState, held: HeldBody | None = None) -> None:
        self._arm, self._chain, self._held = arm, arm.chain(tool_state), held

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints, in the order of the efforts."""
        return self._arm.names

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the efforts."""
        return tuple("N" if unit == "m" else "Nm" for unit in self._arm.robot.units)

    @cached_property
    def _bodies(self) -> tuple[Array, Array, Array]:
        """Masses (L,), centres (L, 3) and inertias (L, 3, 3) of what is fixed to the chain's frames."""
        links = {link.name: link.inertial for link in self._arm.robot.links}
        bodies = [links[joint.child] for joint in self._arm.robot.joints]
        if self._held is not None:
            bodies[-1] = bodies[-1].joined(self._held_in_last(self._held))
        return (
            np.array([body.mass for body in bodies], dtype=np.float64),
            np.array([body.centre for body in bodies], dtype=np.float64),
            np.array([body.inertia for body in bodies], dtype=np.float64),
        )

    def _held_in_last(self, held: HeldBody) -> Inertial:
        T_last_tip = self._arm.robot.tool.T_last_tip
        R = T_last_tip[:3, :3]
        return Inertial(held.mass, R @ held.p_tip_com + T_last_tip[:3, 3], R @ held.inertia @ R.T)

    def efforts(self, Q: Array, dQ: Array, ddQ: Array, gravity: float = GRAVITY) -> Array:
        """Compute the efforts of the motors in every state of a motion.

        Args:
            Q: (N, n) configurations.
            dQ: (N, n) velocities, per s.
            ddQ: (N, n) accelerations, per s^2.
            gravity: m/s^2.

        Returns:
            (N, n) Nm, or N of prismatic joints.
        """
        masses, centres, inertias = self._bodies
        q, dq, ddq = (np.ascontiguousarray(rows, dtype=np.float64) for rows in (Q, dQ, ddQ))
        return self._chain.inverse_dynamics(q, dq, ddq, masses, centres, inertias, gravity)

    def path_efforts(self, Q: Array, dQ: Array, ddQ: Array) -> tuple[Array, Array, Array]:
        """Compute the efforts along a path as a u + b x + c (path acceleration u, squared path velocity x).

        Args:
            Q: (N, n) configurations.
            dQ: (N, n) dq/ds.
            ddQ: (N, n) d2q/ds2.

        Returns:
            a, b and c, each (N, n); c are the efforts at rest.
        """
        zero = np.zeros_like(Q)
        return self.efforts(Q, zero, dQ, 0.0), self.efforts(Q, dQ, ddQ, 0.0), self.efforts(Q, zero, zero)
