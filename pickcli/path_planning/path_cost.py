"""Cost of a polyline: approximate time along it."""

from __future__ import annotations

import numpy as np

from pickcli import kernel
from pickcli.geometry import Array
from pickcli.path_planning.state_space import JointSpace

# Share of the Euclidean length in the cost of an edge. The slowest joint determines the duration, so the
# motion of the others would be free of cost: this share selects the calmer motion among equals.
CALM = 0.05

# Largest distance of a blend from its corner, rad or m; used only for estimates.
_CORNER_DEVIATION = 0.02


def step_costs(space: JointSpace, steps: Array) -> Array:
    """Estimate the duration of edges at full speed, for comparing paths.

    It is the largest |dq_j| / v_j, plus a small share of the length. It obeys the triangle inequality: a
    shortcut never costs more than the edges that it replaces.

    Args:
        space: Velocity limits.
        steps: (..., n) differences of configurations.

    Returns:
        (...,) s.
    """
    seconds = np.abs(steps) / space.velocity
    return np.asarray(seconds.max(axis=-1) + CALM * np.sqrt((seconds * seconds).sum(axis=-1)))


def estimated_duration(space: JointSpace, waypoints: Array) -> float:
    """Estimate the duration from rest to rest along a polyline with blended corners.

    The look-ahead of machine tools: on each edge the speed is bounded by the slowest joint; in each corner by
    the acceleration that a blend of bounded deviation needs; a backward and a forward pass make the speeds
    reachable; each edge then takes its trapezoid. Jerk is neglected.

    Args:
        space: Velocity and acceleration limits.
        waypoints: (N, n) configurations.

    Returns:
        s.
    """
    return kernel.estimated_duration(waypoints, space.velocity, space.acceleration, _CORNER_DEVIATION)
