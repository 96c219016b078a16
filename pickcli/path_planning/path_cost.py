"""Cost of a polyline: its length, or the time that it will take, approximately."""

from __future__ import annotations

import numpy as np

from pickcli import kernel
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
    return kernel.estimated_duration(waypoints, space.velocity, space.acceleration, _CORNER_DEVIATION)
