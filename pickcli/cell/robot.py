"""The robot as data: links, joints, limits."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np

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
    """One joint of the chain. Angles in rad (prismatic: m); limits per second, s^2, s^3."""

    name: str
    type: JointType
    parent: str
    child: str
    T_parent_joint: Array  # (4, 4) pose of the joint frame in the parent link, at position 0
    axis: Array  # (3,) unit axis in the joint frame; motion is along or about it
    lower: float
    upper: float


@dataclass(frozen=True, eq=False)
class Link:
    """One rigid link; its collision shapes stand in the link frame."""

    name: str
    shapes: tuple[Body, ...]
    mass: float  # kg


@dataclass(frozen=True, eq=False)
class Limits:
    """Motion limits of the planned joints, arrays (n,). Positions m or rad; jerk is chosen in the cell."""

    lower: Array
    upper: Array
    velocity: Array
    acceleration: Array
    jerk: Array


@dataclass(frozen=True, eq=False)
class Robot:
    """A serial chain from the world to the cup.

    ``joints`` runs from the base outwards, one joint per link but the root; the joint of the tool, if it has
    one, is the last of them but not among ``joint_names``, which are the planned ones, in the order of every
    configuration ``q``.
    """

    name: str
    urdf: Path
    T_world_base: Array  # (4, 4) pose of the root link in the world
    links: tuple[Link, ...]  # from the root outwards; links[i + 1] is the child of joints[i]
    joints: tuple[Joint, ...]
    joint_names: tuple[str, ...]
    limits: Limits
    motor_forces: dict[str, float]  # N or Nm by joint, for simulation only
    tool: Tool

    @property
    def n_joints(self) -> int:
        """Number of planned joints."""
        return len(self.joint_names)

    def link(self, name: str) -> Link:
        """The link of that name. Raises KeyError."""
        return next(link for link in self.links if link.name == name)


def joint_motion(joint: Joint, position: float) -> Array:
    """Pose (4, 4) of a joint's child in the joint frame at a position in rad (prismatic: m)."""
    if joint.type is JointType.FIXED:
        return np.eye(4)
    if joint.type is JointType.PRISMATIC:
        return pose(position * joint.axis)
    return pose(R=rotation_axis_angle(joint.axis, position))
