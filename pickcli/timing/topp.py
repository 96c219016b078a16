"""Time-optimal path parametrisation by reachability analysis (TOPP-RA) in closed form.

Pham and Pham, "A New Approach to Time-Optimal Path Parameterization Based on Reachability Analysis",
IEEE T-RO 34(3), 2018. With x = (ds/dt)^2 and u = d2s/dt2, constant between gridpoints, every acceleration
limit is a strip |u - m x| <= c. All strips contain the origin, so the controllable sets are intervals
[0, X] and both passes need no linear programs: each step is a minimum over the strips.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array

_TINY = 1e-9


@dataclass(frozen=True, eq=False)
class Grid:
    """A path and its limits: states at M gridpoints, M - 1 intervals between them.

    On an interval that is a line nothing of the path bends; its profile is exact (accelerate, cruise,
    brake) with no gridpoints in between, and its cruise lasts at least ``cruise``.
    """

    s: Array  # (M,), increasing
    dq: Array  # (M, n) dq/ds
    ddq: Array  # (M, n) d2q/ds2
    acceleration: Array  # (M - 1, n) limits on each interval
    speed: Array  # (M,) limit of ds/dt, finite
    line_speed: Array  # (M - 1,) limit of ds/dt inside each interval, used on lines only
    is_line: NDArray[np.bool_]  # (M - 1,)
    cruise: float = 0.0  # s


@dataclass(frozen=True, eq=False)
class Profile:
    """A time-optimal motion along the path: ds/dt is linear in t between the points."""

    t: Array  # (P,), strictly increasing from 0
    s: Array  # (P,)
    v: Array  # (P,) ds/dt, 0 at both ends

    @property
    def duration(self) -> float:
        """s."""
        return float(self.t[-1])

    def position(self, t: Array) -> Array:
        """s at times t (M,), clamped to both ends; exact."""
        t = np.clip(t, 0.0, self.duration)
        i = np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, len(self.t) - 2)
        dt = t - self.t[i]
        slope = (self.v[i + 1] - self.v[i]) / (self.t[i + 1] - self.t[i])
        return np.asarray(self.s[i] + dt * (self.v[i] + 0.5 * slope * dt))


def parametrize(grid: Grid) -> Profile:
    """The fastest motion from rest to rest; limits are enforced at both ends of each interval."""
    slope, width = _strips(grid)
    step = 2.0 * np.diff(grid.s)
    top = _highest(grid, slope, width)
    x = _forward(_backward(top, slope, width, step), slope, width, step)
    return _profile(grid, x, width)


def _strips(grid: Grid) -> tuple[Array, Array]:
    """Slopes m and half-widths c, (M - 1, 2n), of the strips |u - m x_i| <= c of every interval.

    The first n hold at the interval's start, the others at its end, where x is x_i + 2 ds u.
    """
    step = 2.0 * np.diff(grid.s)[:, None]
    at_end = grid.dq[1:] + step * grid.ddq[1:]
    A = np.concatenate([grid.dq[:-1], at_end], axis=1)
    A = np.where(np.abs(A) < _TINY, _TINY, A)
    B = np.concatenate([grid.ddq[:-1], grid.ddq[1:]], axis=1)
    C = np.concatenate([grid.acceleration, grid.acceleration], axis=1)
    return -B / A, C / np.abs(A)


def _highest(grid: Grid, slope: Array, width: Array) -> Array:
    """(M,) largest x that any u can sustain at each gridpoint, speed limit included, 0 at both ends."""
    top = grid.speed**2
    bent = np.flatnonzero(~grid.is_line)
    m, c = slope[bent], width[bent]
    # Strips j and k meet up to x = (c_j + c_k) / (m_j - m_k).
    parting = ((m[:, :, None] - m[:, None, :]) / (c[:, :, None] + c[:, None, :])).max(axis=(1, 2))
    top[bent] = np.minimum(top[bent], 1.0 / np.maximum(parting, _TINY))
    top[0] = top[-1] = 0.0
    return top


# Both passes are chains of a few thousand numbers: plain floats beat small arrays there.


def _backward(top: Array, slope: Array, width: Array, step: Array) -> Array:
    """(M,) upper ends of the controllable sets: from there the end can still be reached at rest."""
    reach = 1.0 + step[:, None] * slope
    per_reach = (1.0 / np.where(reach > _TINY, reach, _TINY)).tolist()
    room = (step[:, None] * width).tolist()
    x = top.tolist()
    for i in range(len(x) - 2, -1, -1):
        after = x[i + 1]
        x[i] = min(x[i], min([(after + r) * p for r, p in zip(room[i], per_reach[i], strict=True)]))
    return np.array(x)


def _forward(controllable: Array, slope: Array, width: Array, step: Array) -> Array:
    """(M,) the fastest x: always the largest acceleration that stays controllable."""
    room, tilt = (step[:, None] * width).tolist(), (step[:, None] * slope).tolist()
    x = controllable.tolist()
    for i in range(len(x) - 1):
        here = x[i]
        gain = min([r + t * here for r, t in zip(room[i], tilt[i], strict=True)])
        x[i + 1] = max(min(x[i + 1], here + gain), 0.0)
    return np.array(x)


def _profile(grid: Grid, x: Array, width: Array) -> Profile:
    """Points in time; on lines with the two points where acceleration ends and braking begins."""
    i = np.flatnonzero(grid.is_line)
    u = width[i].min(axis=1)
    peak = _cruise_speed(grid, x, u, i) ** 2
    rise = grid.s[i] + (peak - x[i]) / (2 * u)
    fall = np.maximum(grid.s[i + 1] - (peak - x[i + 1]) / (2 * u), rise)
    s = np.concatenate([grid.s, rise, fall])
    v = np.sqrt(np.concatenate([x, peak, peak]))
    order = np.argsort(s, kind="stable")
    s, v = s[order], v[order]
    keep = np.concatenate([[True], np.diff(s) > 1e-12 * grid.s[-1]])
    keep[-1] = True
    s, v = s[keep], v[keep]
    dt = 2.0 * np.diff(s) / np.maximum(v[1:] + v[:-1], 1e-12)
    return Profile(np.concatenate([[0.0], np.cumsum(dt)]), s, v)


def _cruise_speed(grid: Grid, x: Array, u: Array, i: NDArray[np.intp]) -> Array:
    """Fastest cruise on the lines i: reached and left with acceleration u, kept for ``grid.cruise``.

    Distance = (v^2 - x0) / 2u + (v^2 - x1) / 2u + v cruise, solved for v.
    """
    half = u * grid.cruise / 2
    fastest = np.sqrt(half**2 + u * (grid.s[i + 1] - grid.s[i]) + (x[i] + x[i + 1]) / 2) - half
    ends = np.sqrt(np.maximum(x[i], x[i + 1]))
    return np.asarray(np.maximum(np.minimum(fastest, grid.line_speed[i]), ends))
