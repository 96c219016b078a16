"""Path fitting: the path of a trajectory as few straight edges, for queries that time it again."""

from __future__ import annotations

import numpy as np

from pickcli.collision.checker import SceneChecker
from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory

_STEPS = (0.02, 0.005)  # s between the points that may become vertices
_TOLERANCE = 0.02  # rad or m, largest distance of the trajectory from the edge between two vertices


def fit_polyline(trajectory: Trajectory, checker: SceneChecker) -> Array | None:
    """Fit a polyline with proven edges to a trajectory, like Douglas and Peucker.

    An edge that is too far off, or not free, is divided where it is farthest from the trajectory.

    Args:
        trajectory: The trajectory to follow, within 0.02 rad or m of each joint.
        checker: Proves the edges.

    Returns:
        Waypoints (N, n) from the start to the end, or None if an edge cannot be proven.
    """
    for step in _STEPS:
        n = max(int(np.ceil(trajectory.duration / step)), 1)
        Q = trajectory.sample(np.linspace(0.0, trajectory.duration, n + 1))
        kept = _divided(Q, checker, 0, n)
        if kept is not None:
            Q[[0, -1]] = trajectory.positions[[0, -1]]
            return np.asarray(Q[[*kept, n]])
    return None


def _divided(Q: Array, checker: SceneChecker, i: int, j: int) -> list[int] | None:
    """Return the start indices of the edges from i to j, or None."""
    along = np.linspace(0.0, 1.0, j - i + 1)[1:-1, None]
    off = np.abs(Q[i + 1 : j] - Q[i] - along * (Q[j] - Q[i])).max(axis=1) if j - i > 1 else np.zeros(1)
    if off.max() <= _TOLERANCE and checker.is_valid_edge(Q[i], Q[j]):
        return [i]
    if j - i == 1:
        return None
    k = i + 1 + int(off.argmax()) if off.max() > 0.0 else (i + j) // 2
    first, second = _divided(Q, checker, i, k), _divided(Q, checker, k, j)
    return None if first is None or second is None else first + second
