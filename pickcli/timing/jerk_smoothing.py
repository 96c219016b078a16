"""Jerk limitation by smoothing of s(t): the path stays the same, only the motion along it changes.

The time-optimal profile switches acceleration instantly. Averaging ds/dt over a window w turns every switch
into a ramp of that length. For a straight move with w = acceleration / jerk the result is the time-optimal
seven-phase profile. All switches are on the time grid: s(t) is a cubic in every cell, so that on straight
lines the quintics of a Trajectory reproduce it exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.geometry import Array
from pickcli.kernel import smoothed_pace
from pickcli.timing.toppra_closed_form import VelocityProfile


@dataclass(frozen=True, eq=False)
class TimeLaw:
    """Time law s(t) along a path, at rest at both ends; d2s/dt2 is linear between the points.

    Attributes:
        t: (K,) s, strictly increasing from 0.
        s: (K,) path parameter, not decreasing.
        ds: (K,) ds/dt.
        dds: (K,) d2s/dt2.
    """

    t: Array
    s: Array
    ds: Array
    dds: Array

    @property
    def duration(self) -> float:
        """Duration from rest to rest, s."""
        return float(self.t[-1])

    def time_scaled(self, factor: float) -> TimeLaw:
        """Return the time law with its time stretched.

        Args:
            factor: Factor on time.

        Returns:
            The slower time law.
        """
        return TimeLaw(self.t * factor, self.s, self.ds / factor, self.dds / factor**2)

    def shifted(self, by: float) -> TimeLaw:
        """Return the time law on a longer path, starting at a later s.

        Args:
            by: Path parameter s of the start.

        Returns:
            The shifted time law.
        """
        return TimeLaw(self.t, self.s + by, self.ds, self.dds)

    def times_at(self, s: Array) -> Array:
        """Return the times at which path parameters are first reached.

        Args:
            s: (M,) path parameters.

        Returns:
            (M,) times in s; exactly 0 and the duration for the ends of the path.
        """
        cells = np.clip(np.searchsorted(self.s, s, side="left") - 1, 0, len(self.t) - 2)
        return np.array([self._time_in(i, at) for i, at in zip(cells.tolist(), s.tolist(), strict=True)])

    def _time_in(self, i: int, s: float) -> float:
        """Return the time at which s is reached in the cell after point i, or at an end of the path."""
        if s >= self.s[-1]:
            return self.duration
        if s <= self.s[0]:
            return 0.0
        start, ds = float(self.s[i]), float(self.ds[i])
        dds, change = float(self.dds[i]), float(self.dds[i + 1] - self.dds[i])
        h = float(self.t[i + 1] - self.t[i])
        low, high = 0.0, 1.0
        for _ in range(32):  # to 1e-12 s
            u = (low + high) / 2
            if start + h * u * (ds + h * u * (dds / 2 + change * u / 6)) < s:
                low = u
            else:
                high = u
        return float(self.t[i]) + h * high


def smooth(profile: VelocityProfile, step: float, n_window: int) -> TimeLaw:
    """Average the speed of a profile over a window, which bounds its jerk.

    Args:
        profile: Time-optimal profile whose acceleration jumps.
        step: s of each cell of the time grid.
        n_window: Cells of the window, at least 1.

    Returns:
        The smooth time law, a window and a cell longer than the profile.
    """
    s, ds, dds = smoothed_pace(profile.t, profile.s, profile.v, step, n_window)
    return TimeLaw(step * np.arange(float(len(s))), s, ds, dds)


def standing(length: float, step: float) -> TimeLaw:
    """Return the time law of a path that is too short for a motion: it is passed in one cell.

    Args:
        length: Path length, in joint units.
        step: s.

    Returns:
        The time law.
    """
    return TimeLaw(np.array([0.0, step]), np.array([0.0, length]), np.zeros(2), np.zeros(2))


def join(laws: Sequence[TimeLaw]) -> TimeLaw:
    """Join time laws; each starts at the s at which the one before it came to rest.

    Args:
        laws: The time laws, at least one.

    Returns:
        The joined time law.
    """
    if len(laws) == 1:
        return laws[0]
    starts = np.cumsum([0.0] + [law.duration for law in laws[:-1]])
    t = np.concatenate([laws[0].t[:1]] + [law.t[1:] + start for law, start in zip(laws, starts, strict=True)])
    rows = [
        np.concatenate([getattr(laws[0], name)[:1]] + [getattr(law, name)[1:] for law in laws])
        for name in ("s", "ds", "dds")
    ]
    return TimeLaw(t, *rows)
