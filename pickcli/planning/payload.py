"""Whether the cup holds the item under the planned motion, and how much slower it must go if not."""

from __future__ import annotations

import numpy as np

from pickcli.cell.robot import PivotState
from pickcli.geometry import Array, inverse
from pickcli.grasping.holding import Load, load
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import Grasp
from pickcli.motion.trajectory import Trajectory

STEP = 0.01  # s between two evaluated states; the motion is jerk-limited, so nothing hides in between


def carried_load(arm: Arm, pivot: PivotState, trajectory: Trajectory, grasp: Grasp, mass: float) -> Load:
    """Worst load on the cup over a trajectory, gravity and acceleration together."""
    duration = trajectory.duration
    t = np.linspace(0.0, duration, max(3, int(np.ceil(duration / STEP)) + 1))
    tips = arm.tips(trajectory.sample(t), pivot)
    p_tip_com = inverse(grasp.T_item_tip)[:3, 3]
    p = tips[:, :3, :3] @ p_tip_com + tips[:, :3, 3]
    dt = float(t[1] - t[0])
    acceleration = np.zeros_like(p)
    acceleration[1:-1] = (p[2:] - 2.0 * p[1:-1] + p[:-2]) / dt**2
    return load(mass, tips[:, :3, :3], p_tip_com, acceleration)


def path_load(arm: Arm, pivot: PivotState, waypoints: Array, grasp: Grasp, mass: float) -> Load:
    """Worst load at rest over the configurations (N, n): no slower motion loads the cup less."""
    tips = arm.tips(waypoints, pivot)
    return load(mass, tips[:, :3, :3], inverse(grasp.T_item_tip)[:3, 3], np.zeros((len(tips), 3)))
