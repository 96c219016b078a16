"""The verifier's own forward kinematics: numpy over all states at once, from the cell's joints.

It shares no code with the kernel on purpose: two programs must agree before the robot moves.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.robot import Joint, JointType, Robot
from pickcli.cell.tool import MOVING, ToolState
from pickcli.geometry import Array, pose, rotation_axis_angle
from pickcli.verification.finger_kinematics import finger_position

# configurations per block: the whole chain stays in the cache, and BLAS stays single-threaded
BLOCK_SIZE = 1024


def link_poses(robot: Robot, Q: Array) -> Array:
    """Return the poses of the robot's links in the world, in the order of ``robot.links``.

    The tool's joints are at 0; links on them are posed by ``T_parent_child``.

    Args:
        robot: The robot.
        Q: (N, n) configurations.

    Returns:
        (L, N, 4, 4).
    """
    out = np.empty((len(robot.joints) + 1, len(Q), 4, 4))
    out[0] = robot.T_world_base
    parents = _parents(robot)
    for first in range(0, len(Q), BLOCK_SIZE):
        block = slice(first, first + BLOCK_SIZE)
        for i, joint in enumerate(robot.joints):
            out[i + 1, block] = _moved(robot, joint, out[parents[i], block], Q[block])
    return out


@lru_cache(maxsize=8)
def _parents(robot: Robot) -> tuple[int, ...]:
    """Return the index of the parent link of each joint."""
    index = {link.name: i for i, link in enumerate(robot.links)}
    return tuple(index[joint.parent] for joint in robot.joints)


def _moved(robot: Robot, joint: Joint, T_world_parent: Array, Q: Array) -> Array:
    """Return poses (N, 4, 4) in the world of a joint's child, from those of its parent and Q (N, n)."""
    rows = T_world_parent.reshape(-1, 4)
    T, *turns = ((rows @ factor).reshape(-1, 4, 4) for factor in _factors(joint))
    if not _is_planned(robot, joint) or joint.type is JointType.FIXED:
        return T
    q = Q[:, robot.joint_names.index(joint.name), None, None]
    if joint.type is JointType.PRISMATIC:
        T[:, :3, 3] += q[:, 0] * (T[:, :3, :3] @ joint.axis)
    else:
        for turn, share in zip(turns, (np.sin(q), 1.0 - np.cos(q)), strict=True):
            T += np.multiply(turn, share, out=turn)
    return T


@lru_cache(maxsize=64)
def _factors(joint: Joint) -> tuple[Array, ...]:
    """Return the factors (4, 4) of the parent's pose: T, and for a joint that turns also A and B.

    The child's pose in the parent is T + sin(q) A + (1 - cos(q)) B (Rodrigues).
    """
    T = joint.T_parent_joint
    if joint.type not in (JointType.REVOLUTE, JointType.CONTINUOUS):
        return (T,)
    x, y, z = joint.axis
    K = np.zeros((4, 4))
    K[:3, :3] = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
    return T, T @ K, T @ K @ K


def _is_planned(robot: Robot, joint: Joint) -> bool:
    return joint.name in robot.joint_names


def last_joint_index(robot: Robot) -> int:
    """Return the index in ``robot.joints`` of the joint that carries the cup.

    Args:
        robot: The robot.

    Returns:
        The index.
    """
    return next(i for i, joint in enumerate(robot.joints) if joint.child == robot.tool.last_link)


def touching_joints(robot: Robot) -> tuple[int, ...]:
    """Return indices in ``robot.joints`` of the joints of the links that may touch a grasped item.

    Args:
        robot: The robot.

    Returns:
        The joint of the cup, or those of both fingers; () without a tool if a planned joint moves the last
        link, which is then a link like any other.
    """
    links = robot.tool.contact_links
    return tuple(
        i for i, joint in enumerate(robot.joints) if joint.child in links and not _is_planned(robot, joint)
    )


def lance_index(robot: Robot) -> int:
    """Return the index in ``robot.links`` of the parent link of the cup.

    Args:
        robot: The robot.

    Returns:
        The index.
    """
    return parent_index(robot, last_joint_index(robot))


def parent_index(robot: Robot, joint: int) -> int:
    """Return the index in ``robot.links`` of a joint's parent link.

    Args:
        robot: The robot.
        joint: Index of the joint.

    Returns:
        The index.
    """
    return _parents(robot)[joint]


def T_lance_last(robot: Robot, tool_state: ToolState) -> Array:
    """Return the pose of the cup link in its parent link.

    Args:
        robot: The robot.
        tool_state: State of the tool.

    Returns:
        (4, 4).
    """
    cup = last_joint_index(robot)
    return T_parent_child(robot, cup, joint_position(robot, cup, stated_position(robot, tool_state)))


def T_parent_child(robot: Robot, index: int, position: float) -> Array:
    """Return the pose of the child of one of the tool's joints in its parent link.

    Args:
        robot: The robot.
        index: Index of the joint.
        position: Position of the joint, rad (prismatic: m).

    Returns:
        (4, 4).
    """
    joint = robot.joints[index]
    if joint.type is JointType.FIXED:
        return joint.T_parent_joint
    if joint.type is JointType.PRISMATIC:
        return joint.T_parent_joint @ pose(position * joint.axis)
    return joint.T_parent_joint @ pose(R=rotation_axis_angle(joint.axis, position))


def stated_position(robot: Robot, tool_state: ToolState) -> float:
    """Return the joint position or width of a tool state; for a moving tool, that of the first named state.

    Args:
        robot: The robot.
        tool_state: State of the tool.

    Returns:
        rad or m.
    """
    positions = robot.tool.positions
    if tool_state == MOVING:
        return next(iter(positions.values()))
    if tool_state in positions:
        return positions[tool_state]
    assert tool_state.width is not None
    return tool_state.width


def joint_position(robot: Robot, index: int, stated: float) -> float:
    """Return the position of one of the tool's joints in a tool state.

    Args:
        robot: The robot.
        index: Index of the joint.
        stated: Value from ``stated_position``, rad or m.

    Returns:
        rad or m.
    """
    if not robot.tool.grip.finger_joints:
        return stated
    return finger_position(robot.tool, robot.joints[index].name, stated)


def tip_poses(robot: Robot, links: Array, tool_state: ToolState) -> Array:
    """Return poses of the tool frame in the world.

    Args:
        robot: The robot.
        links: (L, N, 4, 4) from ``link_poses``.
        tool_state: State of the tool.

    Returns:
        (N, 4, 4).
    """
    last = last_joint_index(robot)
    if _is_planned(robot, robot.joints[last]):
        return np.asarray(links[last + 1] @ robot.tool.T_last_tip)
    return np.asarray(links[lance_index(robot)] @ T_lance_last(robot, tool_state) @ robot.tool.T_last_tip)


def reaches(robot: Robot, link: int, radius: float) -> Array:
    """Bound how far each joint can move any point of a link, per unit of the joint.

    It holds in every configuration within the limits: the path along the links from a joint's axis to the
    point is never shorter than the distance between them.

    Args:
        robot: The robot.
        link: Index of the link.
        radius: m, greatest distance of the points from the link's origin.

    Returns:
        (n,) m/rad (rail: 1).
    """
    base, turns = _reaches_of_origin(robot, link)
    return np.where(turns, base + radius, base)


@lru_cache(maxsize=64)
def _reaches_of_origin(robot: Robot, link: int) -> tuple[Array, NDArray[np.bool_]]:
    """Return the reaches (n,) of a link's origin, and which joints (n,) turn points about it."""
    out, turns = np.zeros(robot.n_joints), np.zeros(robot.n_joints, dtype=bool)
    way = 0.0
    while link > 0:  # joint i carries link i + 1; the loop runs back towards the base
        joint = robot.joints[link - 1]
        if joint.name in robot.joint_names:
            j = robot.joint_names.index(joint.name)
            turns[j] = joint.type is not JointType.PRISMATIC
            out[j] = way if turns[j] else 1.0
            way += 0.0 if turns[j] else max(abs(joint.lower), abs(joint.upper))
        way += float(np.linalg.norm(joint.T_parent_joint[:3, 3]))
        link = _parents(robot)[link - 1]
    return out, turns
