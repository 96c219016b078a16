"""Lower bound on the duration of a motion between two configurations: each joint alone, rest to rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.geometry import Array


def scaled_limits(limits: Limits, scale: float) -> Limits:
    """Scale velocity, acceleration and jerk limits.

    Args:
        limits: Limits of the joints.
        scale: Factor on all three.

    Returns:
        The scaled limits; position limits stay.
    """
    return replace(
        limits,
        velocity=limits.velocity * scale,
        acceleration=limits.acceleration * scale,
        jerk=limits.jerk * scale,
    )


def lower_bound(limits: Limits, q0: Array, q1: Array, has_jerk_limit: bool = True) -> float:
    """Duration that no motion from rest to rest between two configurations can undercut.

    It is the time of the slowest joint alone. Without jerk limit that is the trapezoid of its speed, or the
    triangle; with it every switch of the acceleration is a ramp (the seven phases of Biagiotti and
    Melchiorri, Trajectory Planning, 3.4).

    Args:
        limits: Velocity, acceleration and jerk limits.
        q0: (n,) start.
        q1: (n,) goal.
        has_jerk_limit: Whether the jerk limits hold.

    Returns:
        s.
    """
    distance = np.abs(np.asarray(q1, dtype=float) - q0)
    ramp = limits.acceleration / limits.jerk if has_jerk_limit else np.zeros(len(distance))
    return float(least_durations(distance, limits.velocity, limits.acceleration, ramp).max())


def least_durations(distance: Array, velocity: Array, acceleration: Array, ramp: Array) -> Array:
    """Least duration of each joint alone, from rest to rest.

    Args:
        distance: (n,) at least 0, rad or m.
        velocity: (n,) limits.
        acceleration: (n,) limits.
        ramp: (n,) s from no to full acceleration; 0 without jerk limit.

    Returns:
        (n,) s.
    """
    # Speed that a joint reaches if it brakes at once: with phases of full acceleration, ...
    peak = (np.sqrt((acceleration * ramp) ** 2 + 4 * acceleration * distance) - acceleration * ramp) / 2
    full = np.minimum(peak, velocity)
    with_full = 2 * (full / acceleration + ramp) + (
        distance - full * (full / acceleration + ramp)
    ) / full.clip(1e-300)
    # ... or, where the speed at the end of one ramp up and one down is too much already, without.
    jerk = acceleration / ramp.clip(1e-300)
    slow = np.minimum(np.cbrt(distance**2 * jerk / 4), velocity)
    without = 4 * np.sqrt(slow / jerk) + (distance - 2 * slow * np.sqrt(slow / jerk)) / slow.clip(1e-300)
    reaches_full = full > acceleration * ramp
    return np.where(distance > 0.0, np.where(reaches_full, with_full, without), 0.0)
