"""Moving-average filter from parabolic segments, whose accelerations jump, to a trajectory with limited jerk.

The average of a motion over w seconds has velocities and accelerations no larger than the motion itself,
changes its acceleration at a bounded rate, and takes w s longer. For a trapezoidal velocity profile with w =
acceleration / jerk it is the fastest motion under a jerk limit, the one with seven phases.
"""

from __future__ import annotations

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.geometry import Array
from pickcli.kernel import ParabolicLimits, ParabolicTrajectory, jerk_window, parabolic_accelerations
from pickcli.motion.trajectory import Trajectory
from pickcli.timing.limit_check import check_limits, measure_limits
from pickcli.trajopt.parabolic_segment import TICK

_SAME = 1e-7  # relative to the change by a jerk limit in a tick: accelerations count as collinear


def filter_jerk(
    names: tuple[str, ...],
    motion: ParabolicTrajectory,
    goal: Array,
    parabolic: ParabolicLimits,
    limits: Limits,
) -> Trajectory:
    """Average a motion over its jerk window.

    The result has points where the jerk of a joint changes. Between two points it is a cubic, which the
    quintic of a Trajectory reproduces.

    Args:
        names: Joint names, in the order of the columns.
        motion: The parabolic trajectory to be filtered.
        goal: (n,) configuration in which the result ends exactly; the motion ends there except for rounding.
        parabolic: The limits that the motion was made for.
        limits: The limits that the result is checked against.

    Returns:
        The filtered trajectory, from rest to rest.

    Raises:
        LimitError: If the result breaks a limit, which is a bug.
    """
    n = round(jerk_window(motion.segments, parabolic) / TICK)
    q, v, a = _on_ticks(motion, n)
    travelled = np.concatenate([np.zeros((1, q.shape[1])), np.cumsum(_travel(q, v, a), axis=0)])
    rows = [(row[n:] - row[:-n]) / (n * TICK) for row in (travelled, q, v)]
    slopes = np.diff(rows[2], axis=0)
    bends = np.abs(np.diff(slopes, axis=0)) > _SAME * parabolic.jerk * TICK
    kept = np.flatnonzero(np.concatenate([[True], bends.any(axis=1), [True]]))
    rows = [row[kept] for row in rows]
    rows[0][[0, -1]] = motion.segments[0].q0, goal
    rows[1][[0, -1]] = rows[2][[0, -1]] = 0.0
    made = Trajectory(names, TICK * kept.astype(float), *rows)
    rounding = max(measure_limits(made, limits).time_scale, 1.0)
    made = Trajectory(
        names,
        made.times * rounding,
        made.positions,
        made.velocities / rounding,
        made.accelerations / rounding**2,
    )
    check_limits(made, limits)
    return made


def _on_ticks(motion: ParabolicTrajectory, n_rest: int) -> tuple[Array, Array, Array]:
    """Return positions and velocities at each tick, acceleration during each; rest at both ends."""
    rows = [
        segment.evaluate(TICK * np.arange(float(round(segment.duration / TICK))))
        for segment in motion.segments
    ]
    last = motion.segments[-1].state(motion.segments[-1].duration)
    q = np.concatenate([row[0] for row in rows] + [last.q[None]])
    v = np.concatenate([row[1] for row in rows] + [np.zeros((1, q.shape[1]))])
    pads = ((n_rest, n_rest), (0, 0))
    a = parabolic_accelerations(motion.segments)
    return np.pad(q, pads, mode="edge"), np.pad(v, pads), np.pad(a, pads)


def _travel(q: Array, v: Array, a: Array) -> Array:
    """Return (K, n): integral of the position over each tick."""
    return np.asarray(TICK * (q[:-1] + TICK * (v[:-1] / 2 + TICK * a / 6)))
