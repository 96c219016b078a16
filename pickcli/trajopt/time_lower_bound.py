"""What no motion between two configurations can undercut: each joint alone, from rest to rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.geometry import Array


def scaled_limits(limits: Limits, scale: float) -> Limits:
    """The limits with velocity, acceleration and jerk times ``scale``."""
    return replace(
        limits,
        velocity=limits.velocity * scale,
        acceleration=limits.acceleration * scale,
        jerk=limits.jerk * scale,
    )


def lower_bound(limits: Limits, q0: Array, q1: Array, has_jerk_limit: bool = True) -> float:
    """s that every motion from rest at q0 (n,) to rest at q1 takes at least: the slowest joint's own best.

    Without jerk limit a joint's best is the trapezoid of its speed, or the triangle; with it every switch of
    the acceleration is a ramp (the seven phases of Biagiotti and Melchiorri, Trajectory Planning, 3.4).
    """
    distance = np.abs(np.asarray(q1, dtype=float) - q0)
    ramp = limits.acceleration / limits.jerk if has_jerk_limit else np.zeros(len(distance))
    return float(least_durations(distance, limits.velocity, limits.acceleration, ramp).max())


def least_durations(distance: Array, velocity: Array, acceleration: Array, ramp: Array) -> Array:
    """(n,) s of each joint alone over a distance (n,) >= 0; ramp: s from none to full acceleration."""
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
