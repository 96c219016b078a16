"""Frames of all links of a robot while it carries out a plan, the joints of its tool included."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.cell.robot import Joint, JointType, Robot, joint_motion
from pickcli.cell.tool import MOVING, Tool, ToolState
from pickcli.geometry import Array
from pickcli.motion.plan import Plan

ROUNDING = 1e-6  # s
LOOK = 1e-3  # s


@dataclass(frozen=True, eq=False)
class LinkFrames:
    """The joints of a robot, by where they stand.

    Attributes:
        robot: The robot.
    """

    robot: Robot

    @cached_property
    def world(self) -> str:
        """Name of the frame in which everything stands: no link has it."""
        return "world" if all(link.name != "world" for link in self.robot.links) else "map"

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the planned joints and of those of the tool, which are what moves."""
        return (*self.robot.joint_names, *self.robot.tool.joints)

    @cached_property
    def moving(self) -> tuple[Joint, ...]:
        """The joints that move, the base first."""
        return tuple(joint for joint in self.robot.joints if joint.name in self.joint_names)

    @cached_property
    def standing(self) -> tuple[tuple[str, str, Array], ...]:
        """Parent, child and pose (4, 4) of what never moves: the base, and links on joints that are fixed."""
        base = (self.world, self.robot.links[0].name, self.robot.T_world_base)
        fixed = (joint for joint in self.robot.joints if joint.name not in self.joint_names)
        return (base, *((joint.parent, joint.child, joint.T_parent_joint) for joint in fixed))

    def T_parent_child(self, joint: Joint, position: float) -> Array:
        """Pose of the link that a joint moves, in the link that carries it.

        Args:
            joint: One of the robot.
            position: rad or m.

        Returns:
            (4, 4).
        """
        return np.asarray(joint.T_parent_joint @ joint_motion(joint, position))

    def T_world_link(self, link: str, positions: Array) -> Array:
        """Pose of a link.

        Args:
            link: Name of a link.
            positions: (m,) of the joints of ``joint_names``.

        Returns:
            (4, 4).
        """
        at = dict(zip(self.joint_names, positions.tolist(), strict=True))
        carried_by = {joint.child: joint for joint in self.robot.joints}
        T = np.eye(4)
        while (joint := carried_by.get(link)) is not None:
            moved = 0.0 if joint.type is JointType.FIXED else at.get(joint.name, 0.0)
            T, link = self.T_parent_child(joint, moved) @ T, joint.parent
        return np.asarray(self.robot.T_world_base @ T)


@dataclass(frozen=True, eq=False)
class ToolMotion:
    """Where the joints of the tool stand while a plan is carried out.

    From the command of the device that moves them they take its lead, evenly.

    Attributes:
        tool: The tool.
        times: (K,) s, at which the tool begins or ends to move; never decreasing.
        states: The K states at these times.
    """

    tool: Tool
    times: tuple[float, ...]
    states: tuple[ToolState, ...]

    def positions(self, t: Array) -> Array:
        """Positions of the tool's joints.

        Args:
            t: (N,) s since the start of the plan.

        Returns:
            (N, m) rad or m, in the order of the tool's joints.
        """
        joints = [
            np.interp(t, self.times, [self.tool.joint_position(joint, state) for state in self.states])
            for joint in self.tool.joints
        ]
        return np.array(joints).reshape(len(joints), len(t)).T

    def velocities(self, t: Array) -> Array:
        """Velocities of the tool's joints.

        Args:
            t: (N,) s since the start of the plan.

        Returns:
            (N, m) rad/s or m/s, the mean over a millisecond.
        """
        return (self.positions(t + LOOK / 2) - self.positions(t - LOOK / 2)) / LOOK


def tool_motion(plan: Plan, robot: Robot, movers: tuple[str, ...]) -> ToolMotion:
    """How a plan moves the joints of the tool.

    Args:
        plan: The plan, its events resolved.
        robot: The robot.
        movers: Names of the devices that do.

    Returns:
        The motion: what the segments say of the tool's state, reached when the devices say so.
    """
    first = plan.segments[0].tool_state
    now = robot.tool.default_state if first == MOVING else first
    times, states = [0.0], [now]
    for event in sorted(plan.events, key=lambda event: event.t_trigger or 0.0):
        if event.device in movers and event.t_trigger is not None:
            then = _state_after(plan, event.t_trigger, ToolState(event.action))
            times += [event.t_trigger, event.t_trigger + event.lead]
            states += [now, then]
            now = then
    return ToolMotion(robot.tool, tuple(times), tuple(states))


def _state_after(plan: Plan, t: float, commanded: ToolState) -> ToolState:
    """The state of the first segment from a time on in which the tool rests; fingers may end on an item."""
    resting = (s.tool_state for s in plan.segments if s.t_start >= t - ROUNDING and s.tool_state != MOVING)
    return next(resting, commanded)
