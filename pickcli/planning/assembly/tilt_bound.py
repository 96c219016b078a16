"""The tilt of a held item along a motion, bounded at every instant.

Tilt is the angle between the vertical and what pointed up in the item when it was taken. Between two samples
the item turns by no more than the revolute joints do together.
"""

from __future__ import annotations

import numpy as np

from pickcli.cell.tool import MOVING
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import Plan
from pickcli.timing.trajectory_sampling import states_at

EVERY = 1e-3  # s between samples


def tilts(up: Array, R: Array) -> Array:
    """Return how far a direction is off the vertical.

    Args:
        up: (3,) unit vector in the tool frame.
        R: (N, 3, 3) orientations of the tool in the world.

    Returns:
        (N,) rad.
    """
    return np.asarray(np.arccos(np.clip((R @ up)[:, 2], -1.0, 1.0)))


def why_tilted(arm: Arm, plan: Plan, upright: float) -> Reason | None:
    """Say where a plan tilts its item too far.

    Args:
        arm: Kinematics.
        plan: The plan.
        upright: rad, the most that the item may be tilted from how it stood when it was taken.

    Returns:
        The reason; None if the bound is proven for every instant.
    """
    up = None
    for segment in plan.segments:
        if segment.held is None:
            continue
        if segment.tool_state == MOVING:
            return Reason("tilts the item", f"{segment.kind}", "the tool turns it")
        times = np.append(np.arange(segment.t_start, segment.t_end, EVERY), segment.t_end)
        positions, velocities = states_at(plan.trajectory, times, highest=1)
        R = arm.tips(positions, segment.tool_state)[:, :3, :3]
        up = R[0].T @ (0.0, 0.0, 1.0) if up is None else up
        most = float((tilts(up, R) + _between(arm, velocities)).max())
        if most > upright:
            detail = f"by up to {np.degrees(most):.1f} degrees, {np.degrees(upright):.1f} are allowed"
            return Reason("tilts the item", f"{segment.kind}", detail)
    return None


def _between(arm: Arm, velocities: Array) -> Array:
    """Bound by how many rad (N,) the item turns until the middle between samples, as joints may accelerate.

    velocities: (N, n) at the samples, which are at most ``EVERY`` apart
    """
    turns = arm.turning_joints
    fastest = np.abs(velocities[:, turns]).sum(axis=1)
    gains = EVERY * float(arm.limits.acceleration[turns].sum())
    return np.asarray((fastest + gains) * EVERY / 2)
