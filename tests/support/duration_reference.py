"""The look-ahead of ``kernel.estimated_duration`` in numpy."""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array


def estimated_duration(
    waypoints: Array, velocity: Array, acceleration: Array, corner_deviation: float
) -> float:
    """About the seconds from rest to rest along a polyline (N, n) with blended corners."""
    steps = np.diff(waypoints, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    kept = lengths > 1e-9
    steps, lengths = steps[kept], lengths[kept]
    if len(lengths) == 0:
        return 0.0
    directions = steps / lengths[:, None]
    top = _along(velocity, directions)
    most = _along(acceleration, directions)
    turns = np.diff(directions, axis=0)
    sizes = np.maximum(np.linalg.norm(turns, axis=1), 1e-9)
    reach = np.minimum(4 * corner_deviation / sizes, np.minimum(lengths[:-1], lengths[1:]) / 2)
    squares = np.concatenate([[0.0], _along(acceleration, turns) * 2 * reach, [0.0]])
    for i in reversed(range(len(lengths))):
        squares[i] = min(squares[i], top[i] ** 2, squares[i + 1] + 2 * most[i] * lengths[i])
    for i in range(len(lengths)):
        squares[i + 1] = min(squares[i + 1], top[i] ** 2, squares[i] + 2 * most[i] * lengths[i])
    v0, v1 = np.sqrt(squares[:-1]), np.sqrt(squares[1:])
    peak = np.minimum(top, np.sqrt((2 * most * lengths + v0**2 + v1**2) / 2))
    cruise = np.maximum(lengths - (2 * peak**2 - v0**2 - v1**2) / (2 * most), 0.0)
    return float(((2 * peak - v0 - v1) / most + cruise / peak).sum())


def _along(limits: Array, directions: Array) -> Array:
    """(M,) the least limit (n,) over what each joint has of directions (M, n)."""
    return np.asarray((limits / np.maximum(np.abs(directions), 1e-12)).min(axis=1))
