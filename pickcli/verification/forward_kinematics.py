"""The verifier's own forward kinematics: numpy over all states at once, straight from the cell's joints.

It shares no code with the kernel on purpose: two programs must agree before the robot moves.
"""

from __future__ import annotations

import numpy as np

from pickcli.cell.robot import Joint, JointType, Robot
from pickcli.cell.tool import MOVING, ToolState
from pickcli.geometry import Array, pose, rotation_axis_angle


def link_poses(robot: Robot, Q: Array) -> Array:
    """Poses in the world (L, N, 4, 4) of the robot's links at configurations Q (N, n).

    The links stand in the order of ``robot.links``. The tool's joint stands at 0: what hangs on it is
    posed by ``T_lance_cup``.
    """
    poses = [np.broadcast_to(robot.T_world_base, (len(Q), 4, 4))]
    for joint in robot.joints:
        poses.append(poses[-1] @ (joint.T_parent_joint @ _motion(robot, joint, Q)))
    return np.stack(poses)


def _motion(robot: Robot, joint: Joint, Q: Array) -> Array:
    """Poses (N, 4, 4) of the joint's child in the joint frame."""
    T = np.tile(np.eye(4), (len(Q), 1, 1))
    if joint.name not in robot.joint_names:
        return T
    q = Q[:, robot.joint_names.index(joint.name)]
    if joint.type is JointType.PRISMATIC:
        T[:, :3, 3] = q[:, None] * joint.axis
    elif joint.type is not JointType.FIXED:
        x, y, z = joint.axis
        K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        sine, cosine = np.sin(q)[:, None, None], np.cos(q)[:, None, None]
        T[:, :3, :3] = np.eye(3) + sine * K + (1.0 - cosine) * (K @ K)
    return T


def cup_joint_index(robot: Robot) -> int:
    """Index in ``robot.joints`` of the joint that the cup hangs on; also that of the link before the cup."""
    return next(i for i, joint in enumerate(robot.joints) if joint.child == robot.tool.cup_link)


def T_lance_cup(robot: Robot, position: float) -> Array:
    """Pose (4, 4) of the cup link in the link it hangs on, its joint at ``position`` rad (prismatic: m)."""
    joint = robot.joints[cup_joint_index(robot)]
    if joint.name != robot.tool.joint:
        return joint.T_parent_joint
    if joint.type is JointType.PRISMATIC:
        return joint.T_parent_joint @ pose(position * joint.axis)
    return joint.T_parent_joint @ pose(R=rotation_axis_angle(joint.axis, position))


def cup_position(robot: Robot, tool_state: ToolState) -> float:
    """Position of the tool's joint in rad or m; on the way between two states, that of the first state."""
    positions = robot.tool.positions
    return next(iter(positions.values())) if tool_state == MOVING else positions[tool_state]


def tip_poses(robot: Robot, links: Array, tool_state: ToolState) -> Array:
    """Poses in the world (N, 4, 4) of the tool frame, from ``link_poses`` (L, N, 4, 4)."""
    return np.asarray(
        links[cup_joint_index(robot)]
        @ T_lance_cup(robot, cup_position(robot, tool_state))
        @ robot.tool.T_cup_tip
    )


def reaches(robot: Robot, link: int, radius: float) -> Array:
    """How far, per unit of each joint, any point of a link can be moved by it: (n,), m/rad (rail: 1).

    radius: m, greatest distance of the points in question from the link's origin. Holds in every
    configuration within the limits: the way from a joint's axis to the point along the links is never
    shorter than the distance between them.
    """
    out = np.zeros(robot.n_joints)
    way = radius
    for i in range(link - 1, -1, -1):  # joint i carries link i + 1; the way runs back towards the base
        joint = robot.joints[i]
        if joint.name in robot.joint_names:
            j = robot.joint_names.index(joint.name)
            is_linear = joint.type is JointType.PRISMATIC
            out[j] = 1.0 if is_linear else way
            way += max(abs(joint.lower), abs(joint.upper)) if is_linear else 0.0
        way += float(np.linalg.norm(joint.T_parent_joint[:3, 3]))
    return out
