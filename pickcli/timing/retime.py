"""A pace along a curve that keeps velocity, acceleration and jerk limits and is near the fastest.

1. TOPP-RA under velocity and acceleration limits, with the path's own jerk capped;
2. s(t) smoothed over a window (``smooth``), which bounds the jerk of the switches;
3. where the result breaks a limit, by a factor r of time, the limits are lowered there and it starts anew;
4. what is left after a few rounds, a percent or so, is removed by stretching time.
Several windows are tried, the fastest result is kept. All of it is a pure function of path and limits.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory
from pickcli.timing.blend import Curve
from pickcli.timing.bounds import PathBounds
from pickcli.timing.limits import peaks
from pickcli.timing.smooth import Pace, smooth
from pickcli.timing.topp import Grid, Profile, parametrize

_WINDOWS = (0.1, 0.2, 0.4, 0.65, 1.0, 1.25, 1.55)  # in units of acceleration / jerk
_ROUNDS = 2  # for every window; as many again for the best one

_GOOD = 1.003  # a stretch that is not worth another round


@dataclass(frozen=True, eq=False)
class Timed:
    """One attempt: a pace and the factor of time that makes it keep every limit."""

    pace: Pace
    stretch: float

    @property
    def duration(self) -> float:
        """s, stretched."""
        return self.pace.duration * self.stretch


def retime(curve: Curve, bounds: PathBounds, step: float) -> Timed:
    """The fastest pace found along a curve (length > 0) without stops, from rest to rest.

    step: s of the time grid before stretching, at most; the ramp of an acceleration is a multiple of it
    """
    ramp = float((bounds.limits.acceleration / bounds.limits.jerk).max())
    step = ramp / np.ceil(ramp / step - 1e-9)
    shortest = parametrize(bounds.grid(curve, 1.0, np.inf, 0.0)).duration
    # Short windows pay only where the motion is too short to reach its acceleration limits.
    windows = {max(round(w * ramp / step), 1) for w in _WINDOWS if w >= 1.0 or shortest < 6.0 * w * ramp}
    searches: list[_Search] = []
    for n_window in sorted(windows):
        searches.append(_Search(curve, bounds, step, n_window))
        searches[-1].rounds(_ROUNDS)
        if searches[-1].is_done and step * n_window >= ramp:
            break  # it fits as it is: a longer window only lasts longer
    best = min(searches, key=lambda search: search.best.duration)
    best.rounds(_ROUNDS)
    ratio = float(needed_stretch(curve, bounds, best.best.pace).max())
    return Timed(best.best.pace, max(ratio, 1.0))


class _Search:
    """Rounds of local correction for one window."""

    def __init__(self, curve: Curve, bounds: PathBounds, step: float, n_window: int) -> None:
        window = step * n_window
        ramp = float((bounds.limits.acceleration / bounds.limits.jerk).max())
        self._curve, self._bounds, self._step, self._n_window = curve, bounds, step, n_window
        self._grid = bounds.grid(curve, min(1.0, window / ramp), 1.0, window)
        self.best: Timed
        self.is_done = False

    def rounds(self, n: int) -> None:
        """Up to n more attempts."""
        for _ in range(n):
            if not self.is_done:
                self._round()

    def _round(self) -> None:
        """The next attempt; lowers the limits for the one after it."""
        profile = parametrize(self._grid)
        pace = smooth(profile, self._step, self._n_window)
        ratios = _estimate(self._curve, self._bounds, pace)
        timed = Timed(pace, max(float(ratios.max()), 1.0))
        self.best = timed if not hasattr(self, "best") or timed.duration < self.best.duration else self.best
        self.is_done = timed.stretch <= _GOOD
        if not self.is_done:
            self._grid = _lowered(self._grid, profile, ratios, self._step, self._n_window)


def needed_stretch(curve: Curve, bounds: PathBounds, pace: Pace) -> Array:
    """(K - 1,) per cell of the pace, the factor of time at which its quintics keep all limits."""
    return _ratios(bounds, pace, *peaks(to_trajectory(curve, pace)))


def _estimate(curve: Curve, bounds: PathBounds, pace: Pace) -> Array:
    """The same from the cells' ends and mean jerk: cheaper, and near enough to correct by."""
    trajectory = to_trajectory(curve, pace)
    velocity, acceleration = np.abs(trajectory.velocities), np.abs(trajectory.accelerations)
    jerk = np.abs(np.diff(trajectory.accelerations, axis=0)) / np.diff(pace.t)[:, None]
    return _ratios(
        bounds,
        pace,
        np.maximum(velocity[1:], velocity[:-1]),
        np.maximum(acceleration[1:], acceleration[:-1]),
        jerk,
    )


def _ratios(bounds: PathBounds, pace: Pace, velocity: Array, acceleration: Array, jerk: Array) -> Array:
    start, end = pace.s[:-1], pace.s[1:]
    scale, limits = bounds.lowest(bounds.scales, start, end), bounds.limits
    ratio = np.maximum(
        (velocity / limits.velocity).max(axis=1) / scale,
        np.maximum(
            np.sqrt((acceleration / limits.acceleration).max(axis=1) / scale),
            np.cbrt((jerk / limits.jerk).max(axis=1) / scale),
        ),
    )
    if len(bounds.table_s):
        tool = bounds.tool_speed(pace.s) * pace.ds
        ratio = np.maximum(
            ratio, np.maximum(tool[:-1], tool[1:]) / bounds.lowest(bounds.tool_caps, start, end)
        )
    return np.asarray(ratio)


def to_trajectory(curve: Curve, pace: Pace, names: tuple[str, ...] = ()) -> Trajectory:
    """The motion q(s(t)) at the pace's grid; the quintics in between follow it closely."""
    q, dq, ddq = curve.evaluate_all(pace.s, 2)
    velocity = dq * pace.ds[:, None]
    acceleration = ddq * (pace.ds**2)[:, None] + dq * pace.dds[:, None]
    return Trajectory(names, pace.t, q, velocity, acceleration)


def _lowered(grid: Grid, profile: Profile, ratios: Array, step: float, n_window: int) -> Grid:
    """The grid with its limits lowered where the smoothed motion needs a stretch.

    Smoothing mixes what happens within a window, so a ratio counts for the window around it.
    """
    at = (np.interp(grid.s, profile.s, profile.t) / step + (n_window + 1) / 2).astype(int)
    at = np.clip(at, 0, len(ratios) - 1)
    ratio = np.maximum(_spread(ratios, n_window)[at], 1.0)
    speed = np.interp(grid.s, profile.s, profile.v) / ratio
    speed = np.where(ratio > _GOOD, np.minimum(grid.speed, speed), grid.speed)
    speed[[0, -1]] = grid.speed[[0, -1]]
    between = np.maximum(ratio[1:], ratio[:-1])
    for i in np.flatnonzero(grid.is_line):
        # A long line is broken at its ends only, by what happens in the blends: those are slowed instead.
        is_short = at[i + 1] - at[i] < 3 * n_window
        between[i] = max(float(ratios[at[i] : at[i + 1] + 1].max()), 1.0) if is_short else 1.0
    return replace(grid, speed=speed, acceleration=grid.acceleration / (between**2)[:, None])


def _spread(values: Array, width: int) -> Array:
    """(K,) largest value within ``width`` cells centred on each."""
    padded = np.pad(values, (width // 2, width - 1 - width // 2))
    done = 1
    while done < width:  # maxima over twice as many cells each time
        more = min(done, width - done)
        padded = np.maximum(padded[:-more], padded[more:])
        done += more
    return np.asarray(padded)
