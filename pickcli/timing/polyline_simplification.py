"""Canonical polylines: without repeated points, and without points on the line between others.

Time parameterization divides by edge lengths, which fails for repeated and collinear points.
"""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array

# scaled joint units (rad, m): points within this distance count as one point, or as on one line
POINT_TOLERANCE = 1e-6
NOWHERE = 1e-9  # a path no longer than this has no motion


def canonical(waypoints: Array, tolerances: Array | float = POINT_TOLERANCE) -> Array:
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
    tolerance = np.broadcast_to(np.asarray(tolerances, dtype=float), (len(waypoints),))
    kept = {0}
    stack = [(0, len(waypoints) - 1)]
    while stack:
        first, last = stack.pop()
        kept.add(last)
        worst = _worst_between(waypoints[first : last + 1], tolerance[first : last + 1])
        if worst is not None:
            stack += [(first, first + worst), (first + worst, last)]
    return _without_repeats(waypoints, sorted(kept))


def _worst_between(points: Array, tolerance: Array) -> int | None:
    """Return the index of the point that most needs to be kept between first and last, or None."""
    if len(points) < 3:
        return None
    relative = points - points[0]
    length = float(np.linalg.norm(relative[-1]))
    if length <= POINT_TOLERANCE:
        distance = np.linalg.norm(relative, axis=1)
    else:
        along = np.clip(relative @ relative[-1] / length, 0.0, length)
        distance = np.linalg.norm(relative - along[:, None] * (relative[-1] / length), axis=1)
        # A point behind an earlier one along the chord: the path reverses there.
        distance = np.maximum(distance, np.maximum.accumulate(along) - along)
    share = distance[1:-1] / tolerance[1:-1]
    worst = int(np.argmax(share))
    return 1 + worst if share[worst] > 1.0 else None


def _without_repeats(waypoints: Array, kept: list[int]) -> Array:
    """Return the kept indices without consecutive equal points; the path's end is always kept."""
    out = [kept[0]]
    for index in kept[1:]:
        if np.linalg.norm(waypoints[index] - waypoints[out[-1]]) > POINT_TOLERANCE:
            out.append(index)
        elif index == kept[-1]:
            _end_at(waypoints, out, index)
    return np.array(out)


def _end_at(waypoints: Array, out: list[int], last: int) -> None:
    """End the path at its last waypoint even if that is next to the one kept before it."""
    if len(out) > 1:
        out[-1] = last
    elif np.linalg.norm(waypoints[last] - waypoints[out[0]]) > NOWHERE:
        out.append(last)


def arc_lengths(waypoints: Array, kept: Array) -> Array:
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
