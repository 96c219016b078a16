"""Near time-optimal parameterization of a path under velocity, acceleration and jerk limits.

1. TOPP-RA under velocity and acceleration limits, with the path's own jerk capped;
2. s(t) smoothed over a window (``smooth``), which bounds the jerk of the switches;
3. where the result breaks a limit, by a factor r of time, the limits are lowered and steps 1 and 2 repeated;
4. the excess after some rounds, a percent or so, is removed by scaling time.

The result is a pure function of path and limits.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory
from pickcli.timing.corner_blending import BlendedPath
from pickcli.timing.jerk_smoothing import TimeLaw, smooth
from pickcli.timing.path_limits import PathBounds
from pickcli.timing.toppra_closed_form import PathGrid, VelocityProfile, parametrize

_WIDE_WINDOW = 1.55  # times the ramp: a window that leaves half of the jerk for the path's own curvature
_SHORT_MOTION = 20.0  # ramps: in a motion shorter than this, a wide window may cost more time than it saves
_ROUNDS = 4  # for every window
_MOST_ROUNDS = 12  # the same while the excess is large, as before a very slow part
_SLOWER = 2.0  # at most, from one round to the next
_GOOD_EXCESS = 1.003  # time scale below which no further round is made
_LARGE_EXCESS = 1.03


@dataclass(frozen=True, eq=False)
class TimedPath:
    """One attempt: a time law, and the factor of time at which it keeps every limit of the joints.

    Attributes:
        law: The time law.
        time_scale: Factor of time, at least 1; for the constraint along the path, at most ``_SLOWER``.
    """

    law: TimeLaw
    time_scale: float

    @property
    def duration(self) -> float:
        """Duration after scaling time, s."""
        return self.law.duration * self.time_scale


def retime(curve: BlendedPath, bounds: PathBounds, step: float) -> TimedPath:
    """Find the fastest time law along a path without stops, from rest to rest.

    Args:
        curve: The blended path, longer than 0.
        bounds: Limits along the path.
        step: s of the time grid before scaling, at most; the ramp of an acceleration is a multiple of it.

    Returns:
        The time law and its time scale.
    """
    ramp = float((bounds.limits.acceleration / bounds.limits.jerk).max())
    step = ramp / np.ceil(ramp / step - 1e-9)
    best: TimedPath | None = None
    for window in _windows(curve, bounds, ramp):
        found = _timed(curve, bounds, step, max(round(window / step), 1), window / ramp)
        best = found if best is None or found.duration < best.duration else best
        if best.time_scale == 1.0:
            break  # no limit is broken: a wider window would only last longer
    assert best is not None
    return best


def _windows(curve: BlendedPath, bounds: PathBounds, ramp: float) -> tuple[float, ...]:
    """Return the windows (s) to try, the narrowest first.

    A motion over d from rest to rest that is limited only by jerk has four phases of (d / 2 jerk)^(1/3);
    without jerk limits it would take T = 2 (d / acceleration)^(1/2).
    """
    # Only lines of the closed form cruise between accelerating and braking.
    is_line, cruises = not curve.half_lengths.any(), bounds.constraint is None
    at_full_speed = (np.abs(np.diff(curve.corners, axis=0)) / bounds.limits.velocity).max(axis=1).sum()
    if at_full_speed >= _SHORT_MOTION * ramp:
        return (ramp if is_line and cruises else _WIDE_WINDOW * ramp,)
    shortest = parametrize(bounds.grid(curve, 1.0, np.inf, 0.0)).duration
    phase = min(ramp, float(np.cbrt(ramp * shortest**2 / 8.0)))
    if is_line:
        # The window of the time-optimal motion itself, or one for a switch by twice the acceleration.
        return (phase,) if cruises else (2.0 * phase,)
    return (phase, _WIDE_WINDOW * phase) if shortest < _SHORT_MOTION * ramp else (_WIDE_WINDOW * ramp,)


def _timed(curve: BlendedPath, bounds: PathBounds, step: float, n_window: int, share: float) -> TimedPath:
    """Run rounds of local correction for one window of ``n_window`` cells, ``share`` of a ramp long."""
    grid = bounds.grid(curve, min(1.0, share), 1.0, step * n_window)
    best: TimedPath | None = None
    for k in range(_MOST_ROUNDS):
        profile = parametrize(grid)
        law = smooth(profile, step, n_window)
        ratios = needed_time_scale(curve, bounds, law)
        timed = TimedPath(law, float(ratios.max()))
        best = timed if best is None or timed.duration < best.duration else best
        if timed.time_scale <= (_GOOD_EXCESS if k < _ROUNDS - 1 else _LARGE_EXCESS):
            break
        grid = _lowered(grid, profile, ratios, step, n_window)
    assert best is not None
    return best


def needed_time_scale(curve: BlendedPath, bounds: PathBounds, law: TimeLaw) -> Array:
    """Return the factor of time at which the quintics of each cell of a time law keep all limits.

    That of the constraint is cut at ``_SLOWER``: one state near its limit would slow the whole motion.
    What is left to do, ``timed_run`` does with the timed motion.

    Args:
        curve: The blended path.
        bounds: Limits along it.
        law: The time law, K points.

    Returns:
        (K - 1,) at least 1.
    """
    start, end = law.s[:-1], law.s[1:]
    ratio = curve.needed_time_scale(law, bounds.limits, bounds.lowest(bounds.scales, start, end))
    if len(bounds.table_s):
        ratio = np.maximum(ratio, _tool_ratios(bounds, law))
    if bounds.constraint is not None:
        trajectory = to_trajectory(curve, law)
        states = trajectory.positions, trajectory.velocities, trajectory.accelerations
        needed = bounds.constraint.time_scale(*states)
        ratio = np.maximum(ratio, np.minimum(np.maximum(needed[:-1], needed[1:]), _SLOWER))
    return np.asarray(ratio)


def _tool_ratios(bounds: PathBounds, law: TimeLaw) -> Array:
    """Return the tool's speed over its limit in each cell (K - 1,), by its ends and the boundaries within it.

    The limit of a part holds from its boundary on: an arm that brakes for a slow part is faster up to there.
    """
    edges = bounds.edges[(bounds.edges > law.s[0]) & (bounds.edges < law.s[-1])]
    s = np.concatenate([law.s, edges])
    pace = np.concatenate([law.ds, np.interp(edges, law.s, law.ds)])
    over = bounds.tool_speed(s) * pace / bounds.lowest(bounds.tool_caps, s, s)
    ends = over[: len(law.s)]
    ratios: Array = np.maximum(ends[:-1], ends[1:])
    np.maximum.at(ratios, np.searchsorted(law.s, edges, side="right") - 1, over[len(law.s) :])
    return ratios


def to_trajectory(curve: BlendedPath, law: TimeLaw, names: tuple[str, ...] = ()) -> Trajectory:
    """Build the motion q(s(t)) at the points of a time law; the quintics in between follow it closely.

    Args:
        curve: The blended path.
        law: The time law.
        names: Joint names.

    Returns:
        The trajectory.
    """
    q, dq, ddq = curve.evaluate_all(law.s, 2)
    velocity = dq * law.ds[:, None]
    acceleration = ddq * (law.ds**2)[:, None] + dq * law.dds[:, None]
    return Trajectory(names, law.t, q, velocity, acceleration)


def _lowered(grid: PathGrid, profile: VelocityProfile, ratios: Array, step: float, n_window: int) -> PathGrid:
    """Lower the limits of the grid where the smoothed motion needs more time.

    Smoothing mixes all points within a window, so a ratio applies to the window around it.
    """
    at = (np.interp(grid.s, profile.s, profile.t) / step + (n_window + 1) / 2).astype(int)
    at = np.minimum(np.maximum(at, 0), len(ratios) - 1)
    ratio = _spread(ratios, n_window)[at]
    speed = np.interp(grid.s, profile.s, profile.v) / ratio
    speed = np.where(ratio > _GOOD_EXCESS, np.minimum(grid.speed, speed), grid.speed)
    speed[[0, -1]] = grid.speed[[0, -1]]
    between = np.maximum(ratio[1:], ratio[:-1])
    for i in np.flatnonzero(grid.is_line) if grid.planes is None else ():
        # A long line is broken only at its ends, because of the blends: those are slowed instead.
        is_short = at[i + 1] - at[i] < 3 * n_window
        between[i] = ratios[at[i] : at[i + 1] + 1].max() if is_short else 1.0
    planes = grid.planes and replace(grid.planes, c=grid.planes.c / (ratio**2)[:, None])
    return replace(grid, speed=speed, acceleration=grid.acceleration / (between**2)[:, None], planes=planes)


def _spread(values: Array, width: int) -> Array:
    """Return the (K,) largest values within ``width`` cells centred on each cell."""
    padded, done = np.zeros(len(values) + width - 1), 1
    padded[width // 2 : width // 2 + len(values)] = values
    while done < width:  # maxima over twice as many cells each time
        more = min(done, width - done)
        padded = np.maximum(padded[:-more], padded[more:])
        done += more
    return np.asarray(padded)
