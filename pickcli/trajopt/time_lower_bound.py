"""Lower bound on the duration of a motion between two configurations: each joint by itself, rest to rest."""

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
        The scaled limits; position limits are unchanged.
    """
    return replace(
        limits,
        velocity=limits.velocity * scale,
        acceleration=limits.acceleration * scale,
        jerk=limits.jerk * scale,
    )


def lower_bound(limits: Limits, q0: Array, q1: Array, has_jerk_limit: bool = True) -> float:
    """Compute a duration that no motion from rest to rest between two configurations can undercut.

    It is the time of the slowest joint by itself. Without jerk limit the velocity profile is a trapezoid or a
    triangle; with it every switch of the acceleration is a ramp (the seven phases of Biagiotti and
    Melchiorri, Trajectory Planning, 3.4).

    Args:
        limits: Velocity, acceleration and jerk limits.
        q0: (n,) start.
        q1: (n,) goal.
        has_jerk_limit: Whether the jerk limits apply.

    Returns:
        s.
    """
    distance = np.abs(np.asarray(q1, dtype=float) - q0)
    ramp = limits.acceleration / limits.jerk if has_jerk_limit else np.zeros(len(distance))
    return float(least_durations(distance, limits.velocity, limits.acceleration, ramp).max())


def least_durations(distance: Array, velocity: Array, acceleration: Array, ramp: Array) -> Array:
    """Compute the least duration of each joint by itself, from rest to rest.

    Args:
        distance: (n,) at least 0, rad or m.
        velocity: (n,) limits.
        acceleration: (n,) limits.
        ramp: (n,) s from zero to full acceleration; 0 without jerk limit.

    Returns:
        (n,) s.
    """
    # Velocity that a joint reaches if it brakes at once: with phases of full acceleration, ...
    peak = (np.sqrt((acceleration * ramp) ** 2 + 4 * acceleration * distance) - acceleration * ramp) / 2
    full = np.minimum(peak, velocity)
    with_full = 2 * (full / acceleration + ramp) + (
        distance - full * (full / acceleration + ramp)
    ) / full.clip(1e-300)
    # ... or without, if the velocity after one ramp up and one down would already be too high.
    jerk = acceleration / ramp.clip(1e-300)
    slow = np.minimum(np.cbrt(distance**2 * jerk / 4), velocity)
    without = 4 * np.sqrt(slow / jerk) + (distance - 2 * slow * np.sqrt(slow / jerk)) / slow.clip(1e-300)
    reaches_full = full > acceleration * ramp
    return np.where(distance > 0.0, np.where(reaches_full, with_full, without), 0.0)
