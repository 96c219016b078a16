"""Where a camera of a cell is, for a configuration of the arm."""

from __future__ import annotations

import numpy as np

from pickcli.cell.robot import JointType, Robot
from pickcli.cell.sensors.mounted_camera import MountedCamera
from pickcli.cell.tool import ToolState
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm


def link_poses(robot: Robot, q: Array, tool_state: ToolState) -> dict[str, Array]:
    """Compute the poses of all links.

    Args:
        robot: The robot.
        q: (n,) configuration, rad or m.
        tool_state: State of the tool.

    Returns:
        (4, 4) in the world, by name.
    """
    frames = Arm(robot).chain(tool_state).fk(np.asarray(q, dtype=np.float64))
    return dict(zip((link.name for link in robot.links), (robot.T_world_base, *frames), strict=True))


def camera_pose(robot: Robot, camera: MountedCamera, q: Array, tool_state: ToolState) -> Array:
    """Compute the stated pose of a camera.

    Args:
        robot: The robot.
        camera: The camera.
        q: (n,) configuration, rad or m.
        tool_state: State of the tool.

    Returns:
        (4, 4) in the world.
    """
    if camera.link is None:
        return camera.T_parent_camera
    return np.asarray(link_poses(robot, q, tool_state)[camera.link] @ camera.T_parent_camera)


def farthest_camera(robot: Robot, camera: MountedCamera) -> float:
    """Bound how far a camera on a link is from the base of the robot, in any configuration.

    Args:
        robot: The robot.
        camera: The camera.

    Returns:
        m: the lengths of all links between them, stretched out, and the travel of prismatic joints; infinite
        for a link of another arm that this one does not know.
    """
    if camera.link not in {link.name for link in robot.links}:
        return np.inf
    way, link = float(np.linalg.norm(camera.T_parent_camera[:3, 3])), camera.link
    arriving = {joint.child: joint for joint in robot.joints}
    while link in arriving:
        joint = arriving[link]
        way += float(np.linalg.norm(joint.T_parent_joint[:3, 3]))
        if joint.type is JointType.PRISMATIC:
            way += max(abs(joint.lower), abs(joint.upper))
        link = joint.parent
    return way
