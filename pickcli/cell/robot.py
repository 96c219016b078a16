"""The robot as data: links, joints, limits."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.inertial import Inertial, assumed_inertial
from pickcli.cell.shapes import Body
from pickcli.cell.tool import Tool
from pickcli.geometry import Array, pose, rotation_axis_angle


class JointType(StrEnum):
    """URDF joint types of a serial chain."""

    REVOLUTE = "revolute"
    CONTINUOUS = "continuous"
    PRISMATIC = "prismatic"
    FIXED = "fixed"


@dataclass(frozen=True, eq=False)
class Joint:
    """One joint of the chain. Positions in rad (prismatic: m).

    Attributes:
        name: Unique in the robot.
        type: Kind of motion.
        parent: Name of the parent link.
        child: Name of the child link.
        T_parent_joint: (4, 4) pose of the joint frame in the parent link, at position 0.
        axis: (3,) unit axis in the joint frame; motion is along or about it.
        lower: Lower position limit, infinite for a continuous joint.
        upper: Upper position limit.
        ignored_limits: Limits that the URDF states of a continuous joint, where they have no meaning.
    """

    name: str
    type: JointType
    parent: str
    child: str
    T_parent_joint: Array
    axis: Array
    lower: float
    upper: float
    ignored_limits: tuple[float, float] | None = None


@dataclass(frozen=True, eq=False)
class Link:
    """One rigid link.

    Attributes:
        name: Unique in the robot.
        bodies: Collision shapes, each with its name and its pose in the link frame.
        inertial: Mass, centre of mass and inertia in the link frame.
        states_mass: Whether the URDF states a mass; else ``inertial`` is assumed from the shapes.
        corrects_inertia: Whether the URDF states an inertia that no body has, replaced by that of a box.
    """

    name: str
    bodies: tuple[Body, ...]
    inertial: Inertial
    states_mass: bool = True
    corrects_inertia: bool = False


def massless_link(name: str) -> Link:
    """Make a link that only carries a frame.

    Args:
        name: Unique in the robot.

    Returns:
        A link without shapes, as light as the physics engine accepts.
    """
    return Link(name, (), assumed_inertial(()), states_mass=False)


@dataclass(frozen=True, eq=False)
class Limits:
    """Motion limits of the planned joints, arrays (n,). Jerk limits come from the cell file.

    Attributes:
        lower: Lower position limits, m or rad; -infinity for a continuous joint, unless the cell narrows it.
        upper: Upper position limits; infinity for a continuous joint, unless the cell narrows it.
        velocity: Limits per s.
        acceleration: Limits per s^2.
        jerk: Limits per s^3.
    """

    lower: Array
    upper: Array
    velocity: Array
    acceleration: Array
    jerk: Array

    @property
    def is_continuous(self) -> NDArray[np.bool_]:
        """Mask (n,) of the continuous joints, whose positions are equivalent modulo a whole turn."""
        return np.isinf(self.lower)

    @property
    def window(self) -> tuple[Array, Array]:
        """Finite bounds (n,), (n,) that cover all configurations: a single turn of each continuous joint."""
        is_continuous = self.is_continuous
        return np.where(is_continuous, -np.pi, self.lower), np.where(is_continuous, np.pi, self.upper)


@dataclass(frozen=True, eq=False)
class Robot:
    """A serial chain from the world to the cup.

    ``joints`` runs from the base outwards, with one joint per link except the root. The tool's joint, if it
    has one, is the last of them, and is not in ``joint_names``.

    Attributes:
        name: Name of the robot.
        urdf: Path of its URDF.
        T_world_base: (4, 4) pose of the root link in the world.
        links: From the root outwards; links[i + 1] is the child of joints[i].
        joints: All joints, the base first.
        joint_names: The planned joints, in the order of every configuration ``q``.
        limits: Limits of the planned joints.
        motor_forces: N or Nm by joint name, the largest that each motor exerts.
        tool: What is mounted on the flange.
    """

    name: str
    urdf: Path
    T_world_base: Array
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    joint_names: tuple[str, ...]
    limits: Limits
    motor_forces: dict[str, float]
    tool: Tool

    @property
    def n_joints(self) -> int:
        """Number of planned joints."""
        return len(self.joint_names)

    @property
    def moving_joints(self) -> tuple[str, ...]:
        """Names of all joints that move: the planned ones, then those of the tool."""
        return (*self.joint_names, *self.tool.joints)

    @property
    def units(self) -> tuple[str, ...]:
        """Units of the planned joints' positions: "m" or "rad"."""
        slides = {joint.name for joint in self.joints if joint.type is JointType.PRISMATIC}
        return tuple("m" if name in slides else "rad" for name in self.joint_names)

    @property
    def shoulder(self) -> Array:
        """Position of the first planned joint with all joints at 0: (3,) m in the world."""
        carried_by = {joint.child: joint for joint in self.joints}
        joint = next(joint for joint in self.joints if joint.name == self.joint_names[0])
        T = joint.T_parent_joint
        while (carrier := carried_by.get(joint.parent)) is not None:
            T, joint = carrier.T_parent_joint @ T, carrier
        return np.asarray((self.T_world_base @ T)[:3, 3])

    def link(self, name: str) -> Link:
        """Return the link of a name.

        Args:
            name: Name of the link.

        Returns:
            The link.

        Raises:
            KeyError: No link has that name.
        """
        return next(link for link in self.links if link.name == name)


def joint_motion(joint: Joint, position: float) -> Array:
    """Compute the pose of a joint's child in the joint frame.

    Args:
        joint: The joint.
        position: rad (prismatic: m).

    Returns:
        (4, 4).
    """
    if joint.type is JointType.FIXED:
        return np.eye(4)
    if joint.type is JointType.PRISMATIC:
        return pose(position * joint.axis)
    return pose(R=rotation_axis_angle(joint.axis, position))
