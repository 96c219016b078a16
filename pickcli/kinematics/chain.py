"""The kernel's chain of a robot in one tool state, with the tool's joint as a fixed one.

The kernel's frames form a sequence. Where the robot's tree branches, the sequence makes a detour: along the
branch, which has no moving joints, and from its last frame directly to the continuation of the chain.
"""

from __future__ import annotations

import numpy as np

from pickcli.cell.robot import Joint, JointType, Robot, joint_motion
from pickcli.cell.tool import ToolState
from pickcli.errors import InputError
from pickcli.geometry import Array, inverse
from pickcli.kernel import Chain, JointKind

MAX_FRAMES = 63  # of the kernel's chains: their bits, and that of a held item, fit into one integer

_KERNEL_KIND = {
    JointType.REVOLUTE: JointKind.REVOLUTE,
    JointType.CONTINUOUS: JointKind.REVOLUTE,
    JointType.PRISMATIC: JointKind.PRISMATIC,
    JointType.FIXED: JointKind.FIXED,
}


def build_chain(robot: Robot, tool_state: ToolState) -> Chain:
    """Build the kernel's chain of a robot: frame k is the child link of ``robot.joints[k]``.

    The base's pose, the position of the tool's joint and the detours over branches are included in the joint
    origins.

    Args:
        robot: The robot of a cell.
        tool_state: State of the tool. For MOVING the tool's default state is used: its swept shape is
            relevant to collision checks, not to kinematics.

    Returns:
        The chain.

    Raises:
        InputError: If the joints do not form a chain with branches that ends in the cup, or if a moving joint
            is neither planned nor the tool's.
    """
    _check_chain(robot)
    origins = _origins(robot, tool_state)
    origins[0] = robot.T_world_base @ origins[0]
    fixed = [not is_planned(robot, joint) for joint in robot.joints]
    kinds = [JointKind.FIXED if f else _KERNEL_KIND[j.type] for f, j in zip(fixed, robot.joints, strict=True)]
    indices = [-1 if f else robot.joint_names.index(j.name) for f, j in zip(fixed, robot.joints, strict=True)]
    return Chain(
        np.array(kinds, dtype=np.int32),
        np.ascontiguousarray(origins, dtype=np.float64),
        np.ascontiguousarray([j.axis for j in robot.joints], dtype=np.float64),
        np.array(indices, dtype=np.int32),
    )


def is_planned(robot: Robot, joint: Joint) -> bool:
    """Whether a joint is one of the planned joints.

    Args:
        robot: The robot of a cell.
        joint: One of its joints.

    Returns:
        False for a fixed joint and for joints of the tool.
    """
    return joint.type is not JointType.FIXED and joint.name not in robot.tool.joints


def bodies_of_frames(robot: Robot) -> tuple[int, ...]:
    """Return the number of the rigid body of each frame: how many planned joints lead to it.

    Args:
        robot: The robot of a cell.

    Returns:
        One number per frame, in the order of the chain. Frames of body 0 are fixed to the base; bodies with
        consecutive numbers are connected by one joint.
    """
    return tuple(int(n) for n in np.cumsum([is_planned(robot, joint) for joint in robot.joints]))


def _origins(robot: Robot, tool_state: ToolState) -> list[Array]:
    """Return the pose (4, 4) of each joint in the previous frame of the sequence."""
    before = robot.links[0].name
    T_body_link = {before: np.eye(4)}  # of the links so far, in the last moving frame before them
    origins = []
    for joint in robot.joints:
        origin = joint.T_parent_joint @ _folded(robot, joint, tool_state)
        T_body_link[joint.child] = (
            np.eye(4) if is_planned(robot, joint) else T_body_link[joint.parent] @ origin
        )
        if joint.parent != before:
            origin = inverse(T_body_link[before]) @ T_body_link[joint.parent] @ origin
        origins.append(origin)
        before = joint.child
    return origins


def _folded(robot: Robot, joint: Joint, tool_state: ToolState) -> Array:
    """Return the pose (4, 4) of a child in the joint frame for the tool's joints; identity for others."""
    tool = robot.tool
    if joint.name not in tool.joints:
        return np.eye(4)
    return joint_motion(joint, tool.joint_position(joint.name, tool_state))


def _check_chain(robot: Robot) -> None:
    if len(robot.joints) > MAX_FRAMES:
        raise InputError(
            f"{robot.urdf}: the chain and what hangs on it has {len(robot.joints)} links with shapes, "
            f"{MAX_FRAMES} at most; leave some out by robot.without (apc init: --without), e.g. a hand"
        )
    chain = [robot.joints[-1]]
    by_child = {joint.child: joint for joint in robot.joints}
    while chain[-1].parent in by_child:
        chain.append(by_child[chain[-1].parent])
    if chain[0].child != robot.tool.last_link or chain[-1].parent != robot.links[0].name:
        raise InputError(
            f"{robot.urdf}: the joints must form one chain from the base to {robot.tool.last_link!r}, "
            f"got {' > '.join([chain[-1].parent, *(joint.child for joint in reversed(chain))])}"
        )
    planned = [joint.name for joint in reversed(chain) if is_planned(robot, joint)]
    moving = {joint.name for joint in robot.joints if is_planned(robot, joint)}
    odd = moving.symmetric_difference(planned) | moving.symmetric_difference(robot.joint_names)
    if odd or tuple(planned) != robot.joint_names:
        listed = ", ".join(sorted(odd)) or "their order"
        raise InputError(f"{robot.urdf}: planned joints and moving joints of the chain differ in {listed}")
