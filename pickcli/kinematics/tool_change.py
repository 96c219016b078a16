"""Motion of the tool frame while the tool changes its state and the arm is at rest."""

from __future__ import annotations

import numpy as np

from pickcli.cell.robot import JointType, joint_motion
from pickcli.cell.tool import ToolState
from pickcli.geometry import Array, inverse
from pickcli.kinematics.arm import Arm
from pickcli.kinematics.tip_motion import TipMotion

SAMPLE_TIME = 0.004  # s


def changing_tip(arm: Arm, q: Array, before: ToolState, after: ToolState, duration: float) -> TipMotion:
    """Compute the motion of the tool frame while the tool's joint moves from one state to another.

    The joint follows the quintic from rest to rest, as an actuator with cushioned ends nearly does.

    Args:
        arm: Kinematics of an arm whose tool has a joint.
        q: (n,) configuration in which the arm rests.
        before: State of the tool at the start.
        after: State of the tool at the end.
        duration: s.

    Returns:
        The motion, at instants from 0 to ``duration`` that are at most 4 ms apart.
    """
    tool = arm.robot.tool
    joint = next(joint for joint in arm.robot.joints if joint.name == tool.joint)
    start, way = tool.position(before), tool.position(after) - tool.position(before)
    s = np.linspace(0.0, 1.0, int(np.ceil(duration / SAMPLE_TIME)) + 1)
    positions = start + way * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    speed = (way / duration * 30.0 * (s * (1.0 - s)) ** 2)[:, None]
    acceleration = (way / duration**2 * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s))[:, None]
    T_world_joint = arm.tip(q, before) @ inverse(joint_motion(joint, start) @ tool.T_last_tip)
    poses = np.stack([T_world_joint @ joint_motion(joint, p) @ tool.T_last_tip for p in positions.tolist()])
    axis = np.broadcast_to(T_world_joint[:3, :3] @ joint.axis, (len(s), 3))
    if joint.type is JointType.PRISMATIC:
        still = np.zeros((len(s), 3))
        return TipMotion(poses, speed * axis, still, acceleration * axis, still)
    turning, spinning_up = speed * axis, acceleration * axis
    from_axis = poses[:, :3, 3] - T_world_joint[:3, 3]
    velocity = np.cross(turning, from_axis)
    pulled = np.cross(spinning_up, from_axis) + np.cross(turning, velocity)
    return TipMotion(poses, velocity, turning, pulled, spinning_up)
