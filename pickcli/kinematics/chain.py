"""A robot in one tool state as the kernel's chain: the tool's joint folded in as a fixed one."""

from __future__ import annotations

import numpy as np

from pickcli.cell.robot import Joint, JointType, Robot, joint_motion
from pickcli.cell.tool import ToolState
from pickcli.errors import InputError
from pickcli.geometry import Array
from pickcli.kernel import Chain, JointKind

_KERNEL_KIND = {
    JointType.REVOLUTE: JointKind.REVOLUTE,
    JointType.CONTINUOUS: JointKind.REVOLUTE,
    JointType.PRISMATIC: JointKind.PRISMATIC,
    JointType.FIXED: JointKind.FIXED,
}


def build_chain(robot: Robot, tool_state: ToolState) -> Chain:
    """The kernel's chain of a robot: frame k is the child link of ``robot.joints[k]``.

    The base's pose and the position of the tool's joint are folded into the joint origins.

    Args:
        robot: The robot of a cell.
        tool_state: State of the tool. MOVING stands where the tool's default state does: its swept shape is a
            matter of collision, not of kinematics.

    Returns:
        The chain.

    Raises:
        InputError: If the joints are no serial chain that ends in the cup, or if a moving joint is neither
            planned nor the tool's.
    """
    _check_serial(robot)
    origins = [joint.T_parent_joint @ _folded(robot, joint, tool_state) for joint in robot.joints]
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
    """Whether a joint moves with the configuration.

    Args:
        robot: The robot of a cell.
        joint: One of its joints.

    Returns:
        False for a fixed joint and for that of the tool.
    """
    return joint.type is not JointType.FIXED and joint.name != robot.tool.joint


def bodies_of_frames(robot: Robot) -> tuple[int, ...]:
    """Number of the rigid body that each frame belongs to: how many planned joints lead to it.

    Args:
        robot: The robot of a cell.

    Returns:
        One number per frame, in the order of the chain. Frames of body 0 stand still with the base; bodies
        with neighbouring numbers are joined by one joint.
    """
    return tuple(int(n) for n in np.cumsum([is_planned(robot, joint) for joint in robot.joints]))


def _folded(robot: Robot, joint: Joint, tool_state: ToolState) -> Array:
    """Pose (4, 4) of a joint's child in the joint frame, if it is the tool's; the others stand at 0."""
    tool = robot.tool
    return joint_motion(joint, tool.position(tool_state)) if joint.name == tool.joint else np.eye(4)


def _check_serial(robot: Robot) -> None:
    parents, children = [j.parent for j in robot.joints], [j.child for j in robot.joints]
    if parents[1:] != children[:-1] or children[-1] != robot.tool.cup_link:
        raise InputError(
            f"{robot.urdf}: the joints must form one chain from the base to {robot.tool.cup_link!r}, "
            f"got {' > '.join([parents[0], *children])}"
        )
    moving = {j.name for j in robot.joints if is_planned(robot, j)}
    if moving != set(robot.joint_names):
        odd = ", ".join(sorted(moving ^ set(robot.joint_names)))
        raise InputError(f"{robot.urdf}: planned joints and moving joints of the chain differ in {odd}")
