"""A robot as it is seen from a running conveyor: it travels backwards, on one more joint below its base."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.cell.robot import Joint, JointType, Limits, Robot, massless_link
from pickcli.geometry import Array

FARTHEST = 100.0  # m of travel either way


def travelling(robot: Robot, along: Array, name: str) -> Robot:
    """Put a robot on a linear joint.

    Args:
        robot: The robot.
        along: (3,) unit vector in the world, along which it travels.
        name: Name of the conveyor, after which joint and ground are called.

    Returns:
        The robot with that joint before its own, unlimited in speed.
    """
    ground, root = f"{name} at the contact", robot.links[0].name
    axis = robot.T_world_base[:3, :3].T @ along
    joint = Joint(
        f"travel of {name}",
        JointType.PRISMATIC,
        ground,
        root,
        np.eye(4),
        axis,
        lower=-FARTHEST,
        upper=FARTHEST,
    )
    limits = robot.limits
    rows = (limits.lower, limits.upper, limits.velocity, limits.acceleration, limits.jerk)
    added = (-FARTHEST, FARTHEST, np.inf, np.inf, np.inf)
    return replace(
        robot,
        links=(massless_link(ground), *robot.links),
        joints=(joint, *robot.joints),
        joint_names=(joint.name, *robot.joint_names),
        limits=Limits(*(np.insert(row, 0, end) for row, end in zip(rows, added, strict=True))),
    )
