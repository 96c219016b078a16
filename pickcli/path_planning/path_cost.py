"""Cost of a polyline: its length, or the time that it will take, approximately."""

from __future__ import annotations

import math

import numpy as np

from pickcli.geometry import Array
from pickcli.path_planning.state_space import JointSpace

# Share of the Euclidean length in the cost of an edge. The slowest joint alone sets the duration, so that
# the other joints could swing about for free: this decides between equals, for the calmer motion.
CALM = 0.05

# How far a blend may leave its corner, rad or m. Only an estimate rests on it.
_CORNER_DEVIATION = 0.02


def edge_costs(space: JointSpace, waypoints: Array) -> Array:
    """Approximate duration of each edge at full speed, to compare paths by.

    The largest |dq_j| / v_j, plus a small share of the length. It obeys the triangle inequality: a shortcut
    never costs more than what it cuts.

    Args:
        space: Velocity limits.
        waypoints: (N, n) configurations.

    Returns:
        (N - 1,) s.
    """
    return step_costs(space, np.diff(waypoints, axis=0))


def step_costs(space: JointSpace, steps: Array) -> Array:
    """The costs of edges that are given by their differences (see ``edge_costs``).

    Args:
        space: Velocity limits.
        steps: (..., n) differences of configurations.

    Returns:
        (...,) s.
    """
    seconds = np.abs(steps) / space.velocity
    return np.asarray(seconds.max(axis=-1) + CALM * np.sqrt((seconds * seconds).sum(axis=-1)))


def estimated_duration(space: JointSpace, waypoints: Array) -> float:
    """Approximate duration from rest to rest along a polyline with blended corners.

    The look-ahead of machine tools: on each edge the speed is bounded by the slowest joint; in each corner by
    the acceleration that a blend of bounded deviation needs; a pass backwards and one forwards make the
    speeds reachable; each edge then takes its trapezoid. Jerk is left out.

    Args:
        space: Velocity and acceleration limits.
        waypoints: (N, n) configurations.

    Returns:
        s.
    """
    steps = np.diff(waypoints, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    kept = lengths > 1e-9
    steps, lengths = steps[kept], lengths[kept]
    if len(lengths) == 0:
        return 0.0
    directions = steps / lengths[:, None]
    slopes = np.maximum(np.abs(directions), 1e-12)
    top = np.min(space.velocity / slopes, axis=1)
    acceleration = np.min(space.acceleration / slopes, axis=1)
    corners = np.concatenate([[0.0], _corner_speeds(space, directions, lengths), [0.0]])
    return _look_ahead(lengths, top, acceleration, corners)


def _corner_speeds(space: JointSpace, directions: Array, lengths: Array) -> Array:
    """(N - 2,): fastest speed through each corner of a parabolic blend.

    A parabola that leaves the corner's edges a distance h before and after it deviates by h |du| / 4 and,
    run at speed v, needs the acceleration v^2 du / (2 h).
    """
    turns = np.abs(np.diff(directions, axis=0))
    sizes = np.maximum(np.linalg.norm(turns, axis=1), 1e-9)
    reach = np.minimum(4 * _CORNER_DEVIATION / sizes, np.minimum(lengths[:-1], lengths[1:]) / 2)
    squares = np.min(space.acceleration / np.maximum(turns, 1e-12), axis=1) * 2 * reach
    return np.asarray(np.sqrt(squares))


def _look_ahead(lengths: Array, top: Array, acceleration: Array, corners: Array) -> float:
    """Sum of the trapezoids once no speed at a corner is higher than its neighbours allow."""
    edges = list(zip(lengths.tolist(), top.tolist(), acceleration.tolist(), strict=True))
    speeds: list[float] = corners.tolist()
    for i in range(len(edges) - 1, -1, -1):
        length, fastest, a = edges[i]
        speeds[i] = min(speeds[i], fastest, _reachable(speeds[i + 1], a, length))
    for i, (length, fastest, a) in enumerate(edges):
        speeds[i + 1] = min(speeds[i + 1], fastest, _reachable(speeds[i], a, length))
    return sum(
        _trapezoid(length, speeds[i], speeds[i + 1], fastest, a)
        for i, (length, fastest, a) in enumerate(edges)
    )


def _reachable(speed: float, acceleration: float, length: float) -> float:
    return math.sqrt(speed * speed + 2 * acceleration * length)


def _trapezoid(length: float, v0: float, v1: float, top: float, a: float) -> float:
    """Seconds over a length from speed v0 to v1, never above top, accelerating at a."""
    peak = min(top, math.sqrt((2 * a * length + v0 * v0 + v1 * v1) / 2))
    ramps = (2 * peak * peak - v0 * v0 - v1 * v1) / (2 * a)
    cruise = max(length - ramps, 0.0)
    return (2 * peak - v0 - v1) / a + cruise / peak
