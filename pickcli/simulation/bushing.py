"""Bushing by which a held item hangs on the collapsed cup, or on pads: a spring and damper in six directions.

A cup has two characteristics: relaxed, a soft spring along its axis; sealed and collapsed onto its own folds,
a stiff one in six directions (as OpenPLX's ``SixDofSuctionCup``, Algoryx; a bushing in six directions is
Drake's ``LinearBushingRollPitchYaw`` or Adams' BUSHING). The wrench of the bushing is the load on the cup, so
no load has to be read from the physics solver.

An explicit integration of a stiff spring on a light item is unstable, so the force is taken at the end of the
time step (implicit Euler): with A the item's mobility at the tip (acceleration per wrench), x the deflection,
y the velocity that the item would have after the step h without the bushing,

    F = -(K x + D y+),  D = C + h K,  y+ = y + h A F   =>   (1 + h D A) F = -(K x + D y).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pickcli.geometry import GRAVITY, Array, rotation_vector, skew
from pickcli.simulation.engine import Engine

REFERENCE_RADIUS = 0.015  # m, of the cup whose stiffness is estimated


class BushingStiffness(Protocol):
    """Parameters of a bushing."""

    @property
    def matrix(self) -> Array:
        """(6, 6) for (x, y, z, rotation vector) in the tool frame, N/m and Nm/rad."""

    @property
    def relaxation(self) -> float:
        """Damping over stiffness, s."""


@dataclass(frozen=True)
class Stiffness:
    """Stiffness of a sealed cup about its tip. Estimated in docs/simulation.md, as no maker publishes it.

    By default that of a cup of 30 mm; ``of_cup`` has those of others.

    Attributes:
        axial: N/m along the cup's axis.
        lateral: N/m perpendicular to it.
        tilt: Nm/rad; 60 are 0.6 degrees at the 0.6 Nm where the lip of a 30 mm cup lifts.
        twist: Nm/rad about the axis.
        relaxation: s, damping over stiffness; 3 ms are 0.3 of the critical at 30 Hz.
    """

    axial: float = 4e4
    lateral: float = 2e4
    tilt: float = 60.0
    twist: float = 30.0
    relaxation: float = 3e-3

    @classmethod
    def of_cup(cls, radius: float) -> Stiffness:
        """Return the stiffness of a cup of the same shape and rubber, but another size.

        Of a body that is s times as large, forces per displacement are s times as large, and torques per
        angle s cubed: so are the moments at which the vacuum lets the lip lift.

        Args:
            radius: m.

        Returns:
            The stiffness.
        """
        s, known = radius / REFERENCE_RADIUS, cls()
        return cls(known.axial * s, known.lateral * s, known.tilt * s**3, known.twist * s**3)

    @property
    def matrix(self) -> Array:
        """(6, 6) for (x, y, z, rotation vector) in the tool frame."""
        return np.diag([self.lateral, self.lateral, self.axial, self.tilt, self.tilt, self.twist])


RIGID = Stiffness(axial=1e7, lateral=1e7, tilt=1e5, twist=1e5)


class Bushing:
    """The bushing between the tool tip (b) and the point of the item that the tip took hold of (a).

    Args:
        stiffness: Stiffness of the sealed cup, or of pads.
        mass: Of the item, kg.
        inertia: (3, 3) of the item about its centre of mass, in the tool frame, kg m^2.
        p_tip_com: (3,) centre of mass in the tool frame, m.
        time_step: s.
    """

    def __init__(
        self, stiffness: BushingStiffness, mass: float, inertia: Array, p_tip_com: Array, time_step: float
    ) -> None:
        K = stiffness.matrix
        # The implicit step adds damping h K, so C gets only the rest of the stated damping.
        D = max(stiffness.relaxation, time_step) * K
        implicit = np.linalg.inv(np.eye(6) + time_step * D @ _mobility(mass, inertia, -p_tip_com))
        self._per_deflection, self._per_velocity = -implicit @ K, -implicit @ D
        self._time_step = time_step

    def wrench(self, T_world_a: Array, T_world_b: Array, velocity: Array, gravity: Array) -> Array:
        """Compute force and torque on the item at a during the next step.

        Args:
            T_world_a: (4, 4) frame fixed to the item.
            T_world_b: (4, 4) frame fixed to the tool.
            velocity: (6,) of a relative to b: linear and angular, in the tool frame.
            gravity: (3,) in the tool frame, m/s^2.

        Returns:
            (6,) N and Nm in the tool frame.
        """
        R = T_world_b[:3, :3].T
        deflection = np.empty(6)
        deflection[:3] = R @ (T_world_a[:3, 3] - T_world_b[:3, 3])
        deflection[3:] = rotation_vector(R @ T_world_a[:3, :3])
        free = velocity.copy()
        free[:3] += self._time_step * gravity
        return np.asarray(self._per_deflection @ deflection + self._per_velocity @ free)


@dataclass(frozen=True, eq=False)
class BushingItem:
    """An item that hangs by a bushing on a link of the robot, at one time step.

    Attributes:
        engine: Bodies and their motions.
        item: Name of the item.
        robot: Name of the robot.
        link: Name of its link.
        T_world_a: (4, 4) point of the item that the tool took hold of.
        T_world_tip: (4, 4) tool tip.
    """

    engine: Engine
    item: str
    robot: str
    link: str
    T_world_a: Array
    T_world_tip: Array

    def wrench(self, bushing: Bushing) -> Array:
        """Compute what the bushing exerts on the item during the next step.

        Args:
            bushing: The bushing.

        Returns:
            (6,) N and Nm in the tool frame.
        """
        R, tip = self.T_world_tip[:3, :3], self.T_world_tip[:3, 3]
        relative = self.engine.relative_velocity(self.item, self.robot, self.link, tip)
        velocity = np.concatenate([R.T @ part for part in relative])
        return bushing.wrench(self.T_world_a, self.T_world_tip, velocity, -GRAVITY * R[2])

    def apply(self, wrench: Array) -> None:
        """Exert a wrench on the item, and its opposite on the robot, during the next step.

        Args:
            wrench: (6,) N and Nm in the tool frame.
        """
        R, tip = self.T_world_tip[:3, :3], self.T_world_tip[:3, 3]
        force, torque = R @ wrench[:3], R @ wrench[3:]
        self.engine.apply_force(self.item, force, self.T_world_a[:3, 3])
        self.engine.twist(self.item, torque)
        self.engine.apply_force(self.robot, -force, tip, self.link)
        self.engine.twist(self.robot, -torque, self.link)


def _mobility(mass: float, inertia: Array, p_com_a: Array) -> Array:
    """Linear and angular acceleration (6, 6) at a point a of a free body per force and torque there."""
    lever = skew(p_com_a)
    inverse = np.linalg.inv(inertia)
    return np.block(
        [[np.eye(3) / mass - lever @ inverse @ lever, -lever @ inverse], [inverse @ lever, inverse]]
    )
