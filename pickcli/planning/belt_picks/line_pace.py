"""The pace of lines on a running belt: a share of the limits, so that the belt may change its speed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.planning.pick_motion import GraspMotion

MOST_PACED = 0.85  # of the limits, for lines on a belt
KEPT = 0.97  # of the limits of jerk, that a belt which changes its speed may use up beside the lines


def paced_lines(motion: GraspMotion, pace: float) -> GraspMotion:
    """Return the lines of a grasp at a share of the limits.

    Args:
        motion: The lines.
        pace: The share.

    Returns:
        The lines.
    """
    inward, outward = (tuple(s.scaled(pace) for s in part) for part in (motion.inward, motion.outward))
    return replace(motion, inward=inward, outward=outward)


def line_pace(limits: Limits, change: float) -> float:
    """Compute the share of the limits that leaves room for a rate of time that changes.

    Lines are followed at the pace of the belt. At a share p of the limits, accelerations are p^2 of theirs,
    and a change c of the rate adds a jerk of up to 3 p^2 a c to p of its limit: what is left is a quadratic
    equation for p.

    Args:
        limits: Limits of the joints.
        change: 1/s, of the rate at most.

    Returns:
        The share.
    """
    added = 3.0 * change * float((limits.acceleration / limits.jerk).max())
    return min(MOST_PACED, float(np.sqrt(1.0 + 4.0 * added * KEPT) - 1.0) / (2.0 * added))
