"""Frames of all links of a robot during a plan, including the joints of its tool."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.cell.robot import Joint, JointType, Robot, joint_motion
from pickcli.cell.tool import MOVING, Tool, ToolState
from pickcli.geometry import Array
from pickcli.motion.plan import Plan

TIME_ROUNDING = 1e-6  # s by which two times may differ
DIFFERENCE_TIME = 1e-3  # s, step of numerical differentiation


@dataclass(frozen=True, eq=False)
class LinkFrames:
    """Frames of a robot's links for given joint positions.

    Attributes:
        robot: The robot.
    """

    robot: Robot

    @cached_property
    def world(self) -> str:
        """Name of the world frame, which differs from all link names."""
        return "world" if all(link.name != "world" for link in self.robot.links) else "map"

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of all moving joints: the planned ones and those of the tool."""
        return self.robot.moving_joints

    @cached_property
    def moving(self) -> tuple[Joint, ...]:
        """The moving joints, the base first."""
        return tuple(joint for joint in self.robot.joints if joint.name in self.joint_names)

    @cached_property
    def standing(self) -> tuple[tuple[str, str, Array], ...]:
        """Parent, child and pose (4, 4) of the static frames: the base, and links on fixed joints."""
        base = (self.world, self.robot.links[0].name, self.robot.T_world_base)
        fixed = (joint for joint in self.robot.joints if joint.name not in self.joint_names)
        return (base, *((joint.parent, joint.child, joint.T_parent_joint) for joint in fixed))

    def T_parent_child(self, joint: Joint, position: float) -> Array:
        """Compute the pose of a joint's child link in its parent link.

        Args:
            joint: A joint of the robot.
            position: rad or m.

        Returns:
            (4, 4).
        """
        return np.asarray(joint.T_parent_joint @ joint_motion(joint, position))

    def T_world_link(self, link: str, positions: Array) -> Array:
        """Compute the pose of a link in the world.

        Args:
            link: Name of a link.
            positions: (m,) positions of the joints in ``joint_names``.

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
    """Motion of the tool's joints during a plan.

    They move during the lead of the device, which begins with its command: fingers uniformly, a cup along the
    quintic from rest to rest.

    Attributes:
        tool: The tool.
        times: (K,) s, at which the tool starts or stops moving; nondecreasing.
        states: The K states at these times.
    """

    tool: Tool
    times: tuple[float, ...]
    states: tuple[ToolState, ...]

    def positions(self, t: Array) -> Array:
        """Compute the positions of the tool's joints.

        Args:
            t: (N,) s since the start of the plan.

        Returns:
            (N, m) rad or m, in the order of the tool's joints.
        """
        place = np.interp(t, self.times, np.arange(len(self.times)))  # of the states, with its fraction
        if self.tool.joint is not None:
            whole, s = np.floor(place), place % 1.0
            place = whole + s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        known = np.arange(len(self.states))
        joints = [
            np.interp(place, known, [self.tool.joint_position(joint, state) for state in self.states])
            for joint in self.tool.joints
        ]
        return np.array(joints).reshape(len(joints), len(t)).T

    def velocities(self, t: Array) -> Array:
        """Compute the velocities of the tool's joints.

        Args:
            t: (N,) s since the start of the plan.

        Returns:
            (N, m) rad/s or m/s, the mean over a millisecond.
        """
        return (
            self.positions(t + DIFFERENCE_TIME / 2) - self.positions(t - DIFFERENCE_TIME / 2)
        ) / DIFFERENCE_TIME


def tool_motion(plan: Plan, robot: Robot, movers: tuple[str, ...]) -> ToolMotion:
    """Determine how a plan moves the joints of the tool.

    Args:
        plan: The plan with resolved events.
        robot: The robot.
        movers: Names of the devices that move the tool.

    Returns:
        The motion between the tool states of the segments, timed by the devices.
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
    """First resting state from a time on; fingers may stop on an item instead of the commanded state."""
    resting = (
        s.tool_state for s in plan.segments if s.t_start >= t - TIME_ROUNDING and s.tool_state != MOVING
    )
    return next(resting, commanded)
