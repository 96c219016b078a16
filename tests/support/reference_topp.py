"""TOPP-RA in closed form, in numpy: the oracle of the kernel's passes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array
from pickcli.timing.toppra_closed_form import PathGrid, VelocityProfile

_TINY = 1e-9


def parametrize(grid: PathGrid) -> VelocityProfile:
    """The fastest motion from rest to rest; limits are enforced at both ends of each interval."""
    slope, width = _strips(grid)
    step = 2.0 * np.diff(grid.s)
    top = _highest(grid, slope, width)
    x = _forward(_backward(top, slope, width, step), slope, width, step)
    return _profile(grid, x, width)


def position(profile: VelocityProfile, t: Array) -> Array:
    """Path parameter (M,) at times t (M,), clamped to both ends."""
    t = np.clip(t, 0.0, profile.duration)
    i = np.clip(np.searchsorted(profile.t, t, side="right") - 1, 0, len(profile.t) - 2)
    dt = t - profile.t[i]
    slope = (profile.v[i + 1] - profile.v[i]) / (profile.t[i + 1] - profile.t[i])
    return np.asarray(profile.s[i] + dt * (profile.v[i] + 0.5 * slope * dt))


def smooth(profile: VelocityProfile, step: float, n_window: int) -> tuple[Array, Array, Array]:
    """s, ds/dt and d2s/dt2 (K,) at even times, ds/dt averaged over a window."""
    n_cells = max(int(np.ceil(profile.duration / step - 1e-9)), 1)
    s = position(profile, step * np.arange(n_cells + 1.0))
    rest = np.zeros(n_window + 1)
    speed = np.concatenate([rest, np.diff(s) / step, rest])
    total = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2)])
    ds = np.maximum(total[n_window:] - total[:-n_window], 0.0) / n_window
    dds = (speed[n_window:] - speed[:-n_window]) / (n_window * step)
    ds[[0, -1]] = dds[[0, -1]] = 0.0
    gained = step * ds[:-1] + step**2 * (dds[:-1] / 3 + dds[1:] / 6)
    along = np.concatenate([[0.0], np.cumsum(np.maximum(gained, 0.0))])
    return along * (profile.s[-1] / along[-1]), ds, dds


def _strips(grid: PathGrid) -> tuple[Array, Array]:
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


def _highest(grid: PathGrid, slope: Array, width: Array) -> Array:
    """(M,) largest x that any u can sustain at each gridpoint, speed limit included, 0 at both ends."""
    top = grid.speed**2
    bent = np.flatnonzero(~grid.is_line)
    m, c = slope[bent], width[bent]
    # Strips j and k meet up to x = (c_j + c_k) / (m_j - m_k).
    parting = ((m[:, :, None] - m[:, None, :]) / (c[:, :, None] + c[:, None, :])).max(axis=(1, 2))
    top[bent] = np.minimum(top[bent], 1.0 / np.maximum(parting, _TINY))
    top[0] = top[-1] = 0.0
    return top


def _backward(top: Array, slope: Array, width: Array, step: Array) -> Array:
    """(M,) upper ends of the controllable sets: from there the end can still be reached at rest."""
    x = top.copy()
    for i in range(len(x) - 2, -1, -1):
        reach = np.maximum(1.0 + step[i] * slope[i], _TINY)
        x[i] = min(x[i], ((x[i + 1] + step[i] * width[i]) / reach).min())
    return x


def _forward(controllable: Array, slope: Array, width: Array, step: Array) -> Array:
    """(M,) the fastest x: always the largest acceleration that stays controllable."""
    x = controllable.copy()
    for i in range(len(x) - 1):
        gain = step[i] * (width[i] + slope[i] * x[i]).min()
        x[i + 1] = max(min(x[i + 1], x[i] + gain), 0.0)
    return x


def _profile(grid: PathGrid, x: Array, width: Array) -> VelocityProfile:
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
    return VelocityProfile(np.concatenate([[0.0], np.cumsum(dt)]), s, v)


def _cruise_speed(grid: PathGrid, x: Array, u: Array, i: NDArray[np.intp]) -> Array:
    """Fastest cruise on the lines i: reached and left with acceleration u, kept for ``grid.cruise``.

    Distance = (v^2 - x0) / 2u + (v^2 - x1) / 2u + v cruise, solved for v.
    """
    half = u * grid.cruise / 2
    fastest = np.sqrt(half**2 + u * (grid.s[i + 1] - grid.s[i]) + (x[i] + x[i + 1]) / 2) - half
    ends = np.sqrt(np.maximum(x[i], x[i + 1]))
    return np.asarray(np.maximum(np.minimum(fastest, grid.line_speed[i]), ends))
