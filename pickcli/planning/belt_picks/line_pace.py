"""The pace of lines on a running belt: a share of the limits, so that the belt may change its speed."""

from __future__ import annotations

from dataclasses import replace

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

    Lines are followed at the pace of the belt. At a share p of the limits of velocity, acceleration a and
    jerk j, a change c of the rate adds a jerk of up to 3 p a c to the p j of the lines.

    Args:
        limits: Limits of the joints.
        change: 1/s, of the rate at most.

    Returns:
        The share, at which both are KEPT of the limit.
    """
    added = 3.0 * change * float((limits.acceleration / limits.jerk).max())
    return min(MOST_PACED, KEPT / (1.0 + added))
