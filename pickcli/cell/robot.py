"""The robot and its tool as data: links, joints, limits, the pivoting cup."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from pickcli.cell.cup_limits import CupLimits
from pickcli.cell.shapes import Body
from pickcli.geometry import Array


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


class ToolState(StrEnum):
    """What the pivoting cup does. It is part of the robot's shape, hence of segments and keys."""

    STRAIGHT = "straight"  # cup along the flange's +z
    DOWN = "down"  # cup along the flange's +x
    MOVING = "moving"  # anywhere between the two: the volume that the pivoting cup sweeps


@dataclass(frozen=True, eq=False)
class Tool:
    """The suction tool: a lance whose last part, the cup, pivots.

    The tool frame sits at the tip of the uncompressed cup, +z out of the cup along its axis.
    """

    flange_link: str  # the robot's last own link
    lance_link: str  # fixed to the flange
    cup_link: str  # turned by pivot_joint
    pivot_joint: str
    pivot_positions: dict[ToolState, float]  # rad, STRAIGHT and DOWN
    T_cup_tip: Array  # (4, 4) pose of the tool frame in the cup link
    cup_radius: float  # m
    cup_stroke: float  # m, how far the bellows compress
    cup_stiffness: float  # N/m along the axis while relaxed
    cup_tilt: float  # rad, how far from square on a face the lip still seals
    cup_limits: CupLimits
    contact_speed: float  # m/s, fastest final approach


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

    ``joints`` runs from the base outwards, one joint per link but the root; the pivot joint of the tool
    is among them but not among ``joint_names``, which are the planned ones, in the order of every
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
