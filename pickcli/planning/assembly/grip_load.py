"""Load on the tool along paths and trajectories, to decide whether it holds the item."""

from __future__ import annotations

import numpy as np

from pickcli.cell.tool import ToolState
from pickcli.geometry import Array
from pickcli.grasping.holding import GripLoad, Hold
from pickcli.kinematics.arm import Arm
from pickcli.motion.trajectory import Trajectory
from pickcli.timing.trajectory_sampling import states_at

# s between two evaluated states at most; a jerk of 200 rad/s^3 changes the acceleration by 1 rad/s^2
SAMPLE_TIME = 0.005


def carried_load(arm: Arm, tool_state: ToolState, trajectory: Trajectory, hold: Hold) -> GripLoad:
    """Compute the worst load on the tool over a trajectory, at its points and between them.

    Args:
        arm: Kinematics of the arm.
        tool_state: State of the tool.
        trajectory: The motion.
        hold: The item as the tool holds it.

    Returns:
        The worst value of each component.
    """
    points = trajectory.times
    h = np.diff(points)
    n_each = np.maximum(2, np.ceil(h / SAMPLE_TIME)).astype(int)
    nth = np.arange(n_each.sum()) - np.repeat(np.cumsum(n_each) - n_each, n_each)
    t = np.append(np.repeat(points[:-1], n_each) + nth * np.repeat(h / n_each, n_each), points[-1])
    q, velocity, acceleration = states_at(trajectory, t)
    return hold.in_motion(arm.tip_motion(q, velocity, acceleration, tool_state))


def path_load(arm: Arm, tool_state: ToolState, waypoints: Array, hold: Hold) -> GripLoad:
    """Compute the worst load at rest over configurations, which no slower motion can undercut.

    Args:
        arm: Kinematics of the arm.
        tool_state: State of the tool.
        waypoints: (N, n) configurations.
        hold: The item as the tool holds it.

    Returns:
        The worst value of each component.
    """
    return hold.at_rest(arm.tips(waypoints, tool_state)[:, :3, :3])
