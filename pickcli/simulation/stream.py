"""Samples a trajectory as set points at a fixed time step, at any pace, and checks the set points' limits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory

Pace: TypeAlias = Callable[[float], float]  # seconds since the start -> rate in [0, 1] of the plan's time

LIMIT_TOLERANCE = 1e-6  # relative tolerance of a limit: rounding of third differences at 1 kHz


@dataclass(frozen=True, eq=False)
class Stream:
    """Set points one time step apart; the first is due at the end of the first step.

    Attributes:
        plan_times: (K,) s, time on the plan's trajectory of each.
        points: (K, n) configurations.
    """

    plan_times: Array
    points: Array


@dataclass(frozen=True)
class Violation:
    """A limit that the commands exceeded, at its largest excess.

    Attributes:
        joint: Name of the joint.
        what: "position", "velocity", "acceleration" or "jerk".
        ratio: Value over limit; for a position, how far outside in m or rad.
        t_plan: Time on the plan's trajectory, s.
    """

    joint: str
    what: str
    ratio: float
    t_plan: float

    def __str__(self) -> str:
        return (
            f"{self.joint}: {self.what} at {self.ratio:.4g} of its limit, {self.t_plan:.3f} s into the plan"
        )


def full_speed(t: float) -> float:
    """Return the rate of the plan's own pace.

    Args:
        t: s since the start.

    Returns:
        1.
    """
    return 1.0


def stream(
    trajectory: Trajectory, time_step: float, pace: Pace = full_speed, t_plan: float = 0.0, t: float = 0.0
) -> Stream:
    """Sample the rest of a trajectory as set points.

    Args:
        trajectory: The trajectory.
        time_step: s between set points.
        pace: Rate in [0, 1] of the plan's time as a function of the time since the start; must reach the end.
        t_plan: Time on the trajectory at which to begin, s.
        t: Time since the start at the first set point, s.

    Returns:
        The set points.
    """
    times: list[float] = []
    while t_plan < trajectory.duration:
        t_plan = min(t_plan + pace(t + len(times) * time_step) * time_step, trajectory.duration)
        times.append(t_plan)
    plan_times = np.array(times)
    return Stream(plan_times, trajectory.sample(plan_times))


def violations(
    commands: Stream, names: tuple[str, ...], limits: Limits, time_step: float, scale: float = 1.0
) -> tuple[Violation, ...]:
    """Find the limits that differences of the set points exceed: the largest excess per joint and kind.

    Args:
        commands: The set points.
        names: Names of the joints.
        limits: Limits of the joints.
        time_step: s between set points.
        scale: Factor on velocity and acceleration limits.

    Returns:
        The violations.
    """
    found: list[Violation] = []
    outside = np.maximum(limits.lower - commands.points, commands.points - limits.upper)
    found += _worst("position", names, commands.plan_times, outside, 0.0)
    difference = commands.points
    bounds = (limits.velocity * scale, limits.acceleration * scale, limits.jerk)
    for what, bound in zip(("velocity", "acceleration", "jerk"), bounds, strict=True):
        difference = np.diff(difference, axis=0) / time_step
        times = commands.plan_times[-len(difference) :] if len(difference) else commands.plan_times[:0]
        found += _worst(what, names, times, np.abs(difference) / bound, 1.0)
    return tuple(found)


def _worst(what: str, names: tuple[str, ...], times: Array, ratio: Array, allowed: float) -> list[Violation]:
    found = []
    for j, name in enumerate(names if len(ratio) else ()):
        k = int(np.argmax(ratio[:, j]))
        if ratio[k, j] > allowed + LIMIT_TOLERANCE:
            found.append(Violation(name, what, float(ratio[k, j]), float(times[k])))
    return found
