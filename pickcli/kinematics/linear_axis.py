"""The linear axis that carries a whole arm along a direction, as along a conveyor."""

from __future__ import annotations

import numpy as np

from pickcli.cell.robot import JointType, Robot
from pickcli.geometry import Array
from pickcli.kinematics.chain import is_planned

ALONG = 1e-6  # difference of the cosine from 1 up to which an axis runs along a direction


def linear_axis(robot: Robot, direction: Array) -> tuple[int, float] | None:
    """Find the axis that moves the whole arm along a direction.

    Args:
        robot: The robot.
        direction: (3,) unit vector in the world.

    Returns:
        Index of the first planned joint, and 1.0 or -1.0, the sign of its motion along the direction; None if
        that joint turns, is not parallel to it, or carries less than all bodies of the robot.
    """
    T = robot.T_world_base
    for joint in robot.joints:
        T = T @ joint.T_parent_joint
        if is_planned(robot, joint):
            along = float(T[:3, :3] @ joint.axis @ direction)
            fixed = robot.links[: robot.links.index(robot.link(joint.child))]
            if joint.type is not JointType.PRISMATIC or abs(along) < 1.0 - ALONG:
                return None
            is_whole = not any(link.bodies for link in fixed)
            return (robot.joint_names.index(joint.name), float(np.sign(along))) if is_whole else None
    return None
