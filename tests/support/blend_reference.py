"""A blended path in numpy, all corners at once: what the kernel's BlendedPolyline is held against."""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory
from pickcli.timing.corner_blending import BlendedPath, distinct
from pickcli.timing.jerk_smoothing import TimeLaw
from pickcli.timing.limit_check import peaks
from pickcli.timing.polyline_simplification import POINT_TOLERANCE


def knots(curve: BlendedPath) -> Array:
    """Sorted s of both ends, all stops, and nodes within the blends: four or more per half-length."""
    s, h = curve.corner_s, curve.half_lengths
    found = [np.array([0.0, curve.length]), s[curve.stops]]
    cluster: list[int] = []
    for k in np.flatnonzero(h > 0.0).tolist():
        rest = np.arange(len(s)) >= k
        starts_here = cluster and (s - h)[rest & (h > 0.0)].min() > (s + h)[cluster].max() + POINT_TOLERANCE
        if starts_here:
            found.append(_nodes(s[cluster], h[cluster]))
            cluster = []
        cluster.append(k)
    if cluster:
        found.append(_nodes(s[cluster], h[cluster]))
    return distinct(np.concatenate(found))


def _nodes(s: Array, h: Array) -> Array:
    """Nodes of blends that overlap."""
    if len(s) == 1:
        return np.asarray(s + h * np.linspace(-1.0, 1.0, 9))
    marks = np.unique(np.concatenate([s - h, s - h / 2, s, s + h / 2, s + h]))
    middle = (marks[1:] + marks[:-1]) / 2
    density = 4.0 * ((np.abs(middle[:, None] - s) < h) / h).max(axis=1)
    count = np.concatenate([[0.0], np.cumsum(density * np.diff(marks))])
    levels = np.linspace(0.0, count[-1], max(int(np.ceil(count[-1] - 1e-6)), 2) + 1)
    return np.asarray(np.interp(levels, count, marks))


def evaluate(curve: BlendedPath, s: Array) -> Array:
    """q and its first three derivatives (4, M, n) at s (M,)."""
    at = np.clip(s, 0.0, curve.length)
    edge = np.searchsorted(curve.corner_s[1:-1], at, side="right")
    out = np.zeros((4, len(at), curve.corners.shape[1]))
    out[0] = curve.corners[edge] + curve.directions[edge + 1] * (at - curve.corner_s[edge])[:, None]
    out[1] = curve.directions[edge + 1]
    offset = at[:, None] - curve.corner_s
    return np.asarray(out + np.einsum("dmk,kn->dmn", _bumps(offset, curve.half_lengths), curve.turns))


def _bumps(offset: Array, h: Array) -> Array:
    """(4, M, K): h bump(offset / h) and its derivatives by the offset (M, K); 0 outside of the blend."""
    inside = np.abs(offset) < h
    width = np.where(inside, 2.0 * h, 1.0)
    u = np.where(inside, (offset + h) / width, 0.0)
    past = inside & (offset > 0.0)
    ramp = width * u**4 * (2.5 - 3.0 * u + u**2) - np.where(past, offset, 0.0)
    slope = u**3 * (10.0 - 15.0 * u + 6.0 * u**2) - past
    bend = 30.0 * u**2 * (1.0 - u) ** 2 / width
    return np.stack([ramp, slope, bend, 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / width**2])


def are_lines(curve: BlendedPath, start: Array, end: Array) -> Array:
    """(M,) whether no blend covers the middle of an interval."""
    middle = (start + end) / 2
    return np.asarray(np.all(np.abs(middle[:, None] - curve.corner_s) >= curve.half_lengths, axis=1))


def derivative_bounds(
    curve: BlendedPath, start: Array, end: Array, are_short_wide: bool = True
) -> tuple[Array, Array]:
    """Upper bounds (M, n) of the second and the third derivative on intervals.

    are_short_wide: whether blends shorter than ``POINT_TOLERANCE`` count up to that beside their corner
    """
    h = np.maximum(curve.half_lengths, POINT_TOLERANCE)
    away = np.abs(np.clip(curve.corner_s, start[:, None], end[:, None]) - curve.corner_s)
    x = np.minimum(away / h, 1.0)
    covers = away < curve.half_lengths
    counts = curve.half_lengths > 0.0 if are_short_wide else covers
    second = (15 / 16) * (1.0 - x * x) ** 2 / h * counts
    third = covers * (10.0 / 3.0**0.5 / np.maximum(2.0 * curve.half_lengths, POINT_TOLERANCE) ** 2)
    return second @ np.abs(curve.turns), third @ np.abs(curve.turns)


def deviation(curve: BlendedPath, start: Array, end: Array) -> Array:
    """Upper bounds (M,) of the distance from the polyline on intervals."""
    offset = np.clip(curve.corner_s, start[:, None], end[:, None]) - curve.corner_s
    return np.asarray(_bumps(offset, curve.half_lengths)[0] @ np.linalg.norm(curve.turns, axis=1))


def needed_time_scale(
    curve: BlendedPath, law: TimeLaw, limits: tuple[Array, Array, Array], scale: Array
) -> Array:
    """(K - 1,) factors of time, at least 1, by the peaks of the quintics. limits: (n,) by derivative."""
    q, dq, ddq, _ = evaluate(curve, law.s)
    velocity, acceleration = dq * law.ds[:, None], ddq * (law.ds**2)[:, None] + dq * law.dds[:, None]
    found = peaks(Trajectory((), law.t, q, velocity, acceleration))
    ratios = [(peak / limit).max(axis=1) / scale for peak, limit in zip(found, limits, strict=True)]
    return np.asarray(
        np.max([np.ones(len(scale)), ratios[0], np.sqrt(ratios[1]), np.cbrt(ratios[2])], axis=0)
    )
