"""Canonical polylines: without repeated points, and without points on the line between others.

Time parameterization divides by edge lengths, which fails for repeated and collinear points.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array
from pickcli.kernel import simplified_polyline

# scaled joint units (rad, m): points within this distance count as one point, or as on one line
POINT_TOLERANCE = 1e-6
NOWHERE = 1e-9  # a path no longer than this has no motion


def canonical(waypoints: Array, tolerances: Array | float = POINT_TOLERANCE) -> NDArray[np.int32]:
    """Return indices of the waypoints that shape a path: the first, the last, and all that are needed.

    For a path without motion only index 0 is kept.

    Args:
        waypoints: (N, n) configurations.
        tolerances: (N,) or one for all: a dropped waypoint lies within its tolerance of the chord between its
            kept neighbours. Those between two kept ones advance along their chord, so reversals are kept.

    Returns:
        (K,) indices, increasing.

    Raises:
        ValueError: If the array is empty or not finite.
    """
    if waypoints.ndim != 2 or len(waypoints) == 0 or not np.all(np.isfinite(waypoints)):
        raise ValueError(f"waypoints must be a finite (N, n) array with N >= 1, not {waypoints.shape}")
    tolerance = np.full(len(waypoints), np.asarray(tolerances, dtype=np.float64))
    return simplified_polyline(waypoints, tolerance, POINT_TOLERANCE, NOWHERE)


def arc_lengths(waypoints: Array, kept: NDArray[np.int32]) -> Array:
    """Return the arc length of every waypoint along the polyline through the kept ones.

    Args:
        waypoints: (N, n) configurations.
        kept: (K,) indices of the kept waypoints.

    Returns:
        (N,) s, not decreasing.
    """
    corners = waypoints[kept]
    at_corner = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
    s = np.empty(len(waypoints))
    for k in range(len(kept)):
        first = kept[k]
        last = kept[k + 1] if k + 1 < len(kept) else len(waypoints)
        s[first:last] = at_corner[k]
        if k + 1 < len(kept) and last - first > 1:
            direction = corners[k + 1] - corners[k]
            length = float(np.linalg.norm(direction))
            along = (waypoints[first:last] - corners[k]) @ direction / length
            s[first:last] += np.clip(along, 0.0, length)
    return np.maximum.accumulate(s)
