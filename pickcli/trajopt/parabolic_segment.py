"""Construction of the kernel's parabolic segments: limits, straight lines, rests, whole ticks."""

from __future__ import annotations

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.geometry import Array
from pickcli.kernel import ParabolicLimits, ParabolicSegment

TICK = 0.001  # s

_NOTHING = 1e-12  # m or rad: distance that counts as 0


def parabolic_limits(limits: Limits) -> ParabolicLimits:
    """Derive limits for parabolic segments from the limits of a robot.

    The pause lasts as long as the slowest joint needs to build up its acceleration.

    Args:
        limits: Velocity, acceleration and jerk limits of the joints.

    Returns:
        The limits, with the pause rounded up to ticks.
    """
    ramp = float((limits.acceleration / limits.jerk).max())
    return ParabolicLimits(limits.velocity, limits.acceleration, limits.jerk, float(ticks_up(ramp)))


def resting_segment(q: Array, duration: float) -> ParabolicSegment:
    """Return a segment at rest.

    Args:
        q: (n,) configuration.
        duration: s.

    Returns:
        The segment at rest.
    """
    none = np.zeros(len(q))
    return ParabolicSegment(q, none, none, none, none, none, duration)


def straight_segment(q0: Array, q1: Array, limits: ParabolicLimits) -> ParabolicSegment:
    """Return the fastest segment along a straight line, from rest to rest: all joints ramp simultaneously.

    Args:
        q0: (n,) start.
        q1: (n,) end.
        limits: Velocity and acceleration limits, and the pause.

    Returns:
        The segment.
    """
    way = np.maximum(np.abs(q1 - q0), _NOTHING)
    top, hard = float((limits.velocity / way).min()), float((limits.acceleration / way).min())
    # With the pause as cruise: top^2 / hard + top * pause = 1.
    top = min(top, (np.sqrt((hard * limits.pause) ** 2 + 4 * hard) - hard * limits.pause) / 2)
    up = float(ticks_up(top / hard))
    cruise = float(ticks_up(1 / top - top / hard))
    speed, ramps, none = (q1 - q0) / (up + cruise), np.full(len(q0), up), np.zeros(len(q0))
    return ParabolicSegment(q0, none, speed, none, ramps, ramps, 2 * up + cruise)


def ticks_up(t: Array | float) -> Array:
    """Round times up to whole ticks, except for rounding errors.

    Args:
        t: Times of any shape, s.

    Returns:
        The rounded times, s.
    """
    return np.asarray(np.ceil(t / TICK - 1e-6) * TICK)
