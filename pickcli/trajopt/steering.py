"""Steering: parabolic segments between two moving states, without regard to obstacles.

The fastest segment, the segment of a given duration, and two segments by way of a third state.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array
from pickcli.trajopt.parabolic_segment import TICK, JointState, ParabolicLimits, ParabolicSegment, ticks_up

_ROUNDING = 1e-9  # relative: how far beyond a limit rounding may lead
_NOTHING = 1e-12  # m or rad, per s: what counts as none

# Ticks added in turn to the least time of the slowest joint where another joint has no segment just then:
# because of the rounding to ticks, or as it would have to wait and cannot (Hauser and Ng-Thow-Hing 2010,
# III-C).
_EXTRA = (0, 1, 2, 4, 8, 16, 32)


def steer_min_time(
    start: JointState, end: JointState, pace: ParabolicLimits, at_most: float
) -> ParabolicSegment | None:
    """The segment of least time between two states.

    Args:
        start: State in which it begins.
        end: State in which it ends.
        pace: Velocity and acceleration limits, and the pause.
        at_most: Longest duration that is wanted, s.

    Returns:
        The segment; None if it takes longer than ``at_most``, or if a joint has no segment of any of the
        times tried.
    """
    least = float(ticks_up(least_time(end.q - start.q, start.v, end.v, pace).max()))
    for extra in _EXTRA:
        duration = max(least, TICK) + extra * TICK
        if duration > at_most + TICK / 2:
            return None
        segment = steer_fixed_time(start, end, pace, duration)
        if segment is not None:
            return segment
    return None


def least_time(d: Array, v0: Array, v1: Array, pace: ParabolicLimits) -> Array:
    """Time that each joint needs alone, with full ramps and the pause in between.

    Args:
        d: (n,) distances, rad or m.
        v0: (n,) velocities at the start.
        v1: (n,) velocities at the end.
        pace: Velocity and acceleration limits, and the pause.

    Returns:
        (n,) s.
    """
    a, top = pace.acceleration, pace.velocity
    beyond = d - (v0 + v1) / 2 * np.abs(v1 - v0) / a  # what a single ramp from v0 to v1 leaves
    sign = np.where(beyond < 0.0, -1.0, 1.0)
    d, v0, v1, beyond = sign * d, sign * v0, sign * v1, sign * beyond
    half = a * pace.pause / 2
    peak = np.sqrt(np.maximum(half * half + a * d + (v0 * v0 + v1 * v1) / 2, 0.0)) - half
    faster = np.maximum(v0, v1)
    peak = np.minimum(np.maximum(peak, faster), top)
    cruised = d - (2 * peak * peak - v0 * v0 - v1 * v1) / (2 * a)
    cruise = np.where(np.abs(peak) > _NOTHING, cruised / np.where(peak == 0.0, 1.0, peak), 0.0)
    return np.asarray((2 * peak - v0 - v1) / a + np.maximum(cruise, 0.0))


def steer_fixed_time(
    start: JointState, end: JointState, pace: ParabolicLimits, duration: float
) -> ParabolicSegment | None:
    """The segment of a given duration between two states.

    Args:
        start: State in which it begins.
        end: State in which it ends.
        pace: Velocity and acceleration limits, and the pause.
        duration: s, a whole number of ticks.

    Returns:
        The segment, or None if a joint has none of that duration.
    """
    speed, up, down, is_good = _calm_ramps(end.q - start.q, start.v, end.v, pace, duration)
    return ParabolicSegment(start.q, start.v, speed, end.v, up, down, duration) if is_good.all() else None


def steer_via(
    start: JointState,
    middles: Sequence[JointState],
    end: JointState,
    pace: ParabolicLimits,
    there: float,
    back: float,
) -> tuple[ParabolicSegment, ParabolicSegment] | None:
    """Two segments by way of a state in between, which every joint chooses on its own.

    Every joint takes the first of the middle states for which it has both segments.

    Args:
        start: State in which the first segment begins.
        middles: States to choose from, the preferred first.
        end: State in which the second segment ends.
        pace: Velocity and acceleration limits, and the pause.
        there: Duration of the first segment, s.
        back: Duration of the second segment, s.

    Returns:
        Both segments, or None if a joint has no choice.
    """
    q, v = np.stack([middle.q for middle in middles]), np.stack([middle.v for middle in middles])
    *first, is_there = _calm_ramps(q - start.q, start.v, v, pace, there)
    *last, is_back = _calm_ramps(end.q - q, v, end.v, pace, back)
    is_good = is_there & is_back
    if not is_good.any(axis=0).all():
        return None
    pick = is_good.argmax(axis=0), np.arange(len(start.q))
    speed, up, down = (row[pick] for row in first)
    onward = (row[pick] for row in last)
    return (
        ParabolicSegment(start.q, start.v, speed, v[pick], up, down, there),
        ParabolicSegment(q[pick], v[pick], next(onward), end.v, next(onward), next(onward), back),
    )


def _calm_ramps(
    d: Array, v0: Array, v1: Array, pace: ParabolicLimits, duration: float
) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """``_ramps`` with half of the acceleration where a joint can, else with all of it.

    With half, no jerk limit minds a ramp up next to a ramp down; and it is calmer.
    """
    *calm, is_calm = _ramps(d, v0, v1, pace, 0.5, duration, 0.0)
    if is_calm.all():
        return calm[0], calm[1], calm[2], is_calm
    *hard, is_hard = _ramps(d, v0, v1, pace, 1.0, duration, pace.pause)
    speed, up, down = (np.where(is_calm, a, b) for a, b in zip(calm, hard, strict=True))
    return speed, up, down, is_calm | is_hard


def _ramps(
    d: Array, v0: Array, v1: Array, pace: ParabolicLimits, share: float, duration: float, pause: float
) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """Speed, up and down (..., n) with a share of the acceleration, and where that keeps the limits.

    The distance grows with the speed in between, so there is one speed for every distance: linear where it
    lies between v0 and v1, else the root of a quadratic, and linear again once ramps are rounded to ticks.
    """
    a = share * pace.acceleration
    ramp = np.abs(v1 - v0) / a
    total = v0 + v1
    between = (d - total / 2 * ramp) / np.maximum(duration - ramp, _NOTHING)
    sign = np.where(between > np.maximum(v0, v1), 1.0, -1.0)
    is_between = (between <= np.maximum(v0, v1)) & (between >= np.minimum(v0, v1))
    b = duration + sign * total / a
    root = b * b - 4 / a * ((v0 * v0 + v1 * v1) / (2 * a) + sign * d)
    speed = np.where(is_between, between, sign * a / 2 * (b - np.sqrt(np.maximum(root, 0.0))))
    for _ in range(2):
        up, down = _ramp_times(speed - v0, a), _ramp_times(v1 - speed, a)
        speed = (d - (v0 * up + v1 * down) / 2) / np.maximum(duration - (up + down) / 2, TICK)
    first, last = speed - v0, v1 - speed
    cruise = duration - up - down
    slack = _ROUNDING * pace.velocity
    is_good = (
        (np.abs(first) <= a * up + slack * (up > 0.0) + _NOTHING)
        & (np.abs(last) <= a * down + slack * (down > 0.0) + _NOTHING)
        & (np.abs(speed) <= pace.velocity + slack)
        & (cruise >= np.where(first * last < 0.0, pause, 0.0) - TICK / 2)
    )
    return speed, up, down, is_good


def _ramp_times(change: Array, acceleration: Array) -> Array:
    """Whole ticks for changes of speed: at least one where the speed changes."""
    change = np.abs(change)
    return np.maximum(ticks_up(change / acceleration), np.where(change > _NOTHING, TICK, 0.0))
