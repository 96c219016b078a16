"""Bounds of polynomials by their Bernstein form.

A curve never leaves the convex hull of its control points, and is never longer than their polygon. Bounds are
conservative, and tight to a stated tolerance.
"""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory

RELATIVE = 1e-9  # how far above the true maximum a bound may lie
MOST_PIECES = 100_000  # pieces that may hold a maximum; with more, the current upper bound is returned


def control_points(trajectory: Trajectory, derivative: int) -> Array:
    """Return the Bernstein control points of a time derivative of each piece of a trajectory.

    Args:
        trajectory: N points with quintics in between.
        derivative: 0 to 3.

    Returns:
        (N - 1, 6 - derivative, n).
    """
    h = np.diff(trajectory.times)[:, None]
    points = _legs(trajectory.positions, trajectory.velocities, trajectory.accelerations, h)
    if derivative == 0:
        start = trajectory.positions[None, :-1]
        points = np.concatenate([start, start + np.cumsum(points, axis=0)])
    else:
        points = 5 * points / h
    for degree in range(4, 5 - derivative, -1):
        points = degree * np.diff(points, axis=0) / h
    return np.asarray(np.swapaxes(points, 0, 1))


def _legs(p: Array, v: Array, a: Array, h: Array) -> Array:
    """Return the differences of consecutive control points of every quintic, (5, pieces, n).

    p, v, a: (pieces + 1, n) at the knots. h: (pieces, 1) s between them. Only differences of positions are
    used: rounding at the scale of a radian, divided by the cube of a few ms, would show in the jerk.
    """
    start, end = h * v[:-1] / 5, h * v[1:] / 5
    bent_start, bent_end = start + h * h * a[:-1] / 20, end - h * h * a[1:] / 20
    middle = np.diff(p, axis=0) - start - bent_start - bent_end - end
    return np.stack([start, bent_start, middle, bent_end, end])


def largest(points: Array) -> Array:
    """Return an upper bound of the largest value of polynomials over their pieces.

    It is within RELATIVE of the true value, except for adversarial curves: pieces that cannot hold the
    maximum are dropped, the others are halved; the error of the hull shrinks with the square of their length.

    Args:
        points: (P, d + 1, n) control points.

    Returns:
        (n,).
    """
    n = points.shape[2]
    of = np.tile(np.arange(n), len(points))  # index in n of each polynomial
    points = np.swapaxes(points, 1, 2).reshape(-1, points.shape[1])
    attained: Array = np.full(n, -np.inf)
    found = attained
    while 0 < len(points) <= MOST_PIECES:
        np.maximum.at(attained, of, np.maximum(points[:, 0], points[:, -1]))
        slack = RELATIVE * np.maximum(1e-6, np.abs(attained))
        found = attained + slack
        may_hold = points.max(axis=1) > found[of]
        points, of = points[may_hold], of[may_hold]
        points, of = np.concatenate(_halves(points)), np.concatenate([of, of])
    np.maximum.at(found, of, points.max(axis=1))
    return np.asarray(found)


def _halves(points: Array) -> tuple[Array, Array]:
    """Halve polynomials (P, d + 1) by de Casteljau's algorithm."""
    left, right = [points[:, 0]], [points[:, -1]]
    while points.shape[1] > 1:
        points = (points[:, :-1] + points[:, 1:]) / 2
        left.append(points[:, 0])
        right.append(points[:, -1])
    return np.stack(left, axis=1), np.stack(right[::-1], axis=1)


def variation(p: Array, v: Array, a: Array, times: Array) -> Array:
    """Bound how far each joint travels between consecutive times.

    Each interval must lie within one quintic; its length is then at most that of its control polygon.

    Args:
        p: (M, n) positions at the times, see ``motion``.
        v: (M, n) velocities.
        a: (M, n) accelerations.
        times: (M,) s, strictly increasing, including every knot of the trajectory that lies between them.

    Returns:
        (M - 1, n) rad or m.
    """
    return np.asarray(np.abs(_legs(p, v, a, np.diff(times)[:, None])).sum(axis=0))


def motion(trajectory: Trajectory, times: Array) -> tuple[Array, Array, Array]:
    """Return positions, velocities and accelerations at given times.

    Times outside of the trajectory are clamped to its ends, where it is at rest.

    Args:
        trajectory: The trajectory.
        times: (M,) s.

    Returns:
        (M, n) each.
    """
    (c0, c1, c2, c3, c4, c5), u, h = _pieces_at(trajectory, times)
    p = c0 + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))))
    v = (c1 + u * (2 * c2 + u * (3 * c3 + u * (4 * c4 + u * (5 * c5))))) / h
    a = (2 * c2 + u * (6 * c3 + u * (12 * c4 + u * (20 * c5)))) / (h * h)
    return p, v, a


def positions_at(trajectory: Trajectory, times: Array | float) -> Array:
    """Return positions at given times, those of ``motion``; at the knots without any rounding.

    Args:
        trajectory: The trajectory.
        times: (M,) s, or one time.

    Returns:
        (M, n).
    """
    times = np.atleast_1d(times)
    (c0, c1, c2, c3, c4, c5), u, _ = _pieces_at(trajectory, times)
    p = c0 + u * (c1 + u * (c2 + u * (c3 + u * (c4 + u * c5))))
    p[times >= trajectory.duration] = trajectory.positions[-1]
    return p


def _pieces_at(trajectory: Trajectory, times: Array) -> tuple[list[Array], Array, Array]:
    """Return six coefficients (M, n) of the pieces at times (M,), u (M, 1) in each, and durations (M, 1)."""
    knots = trajectory.times
    times = np.clip(times, 0.0, knots[-1])
    i = np.minimum(np.searchsorted(knots, times, side="right") - 1, len(knots) - 2)
    h = np.diff(knots)[i, None]
    return [c[i] for c in _powers(trajectory)], (times[:, None] - knots[i, None]) / h, h


def _powers(trajectory: Trajectory) -> Array:
    """Return coefficients (6, pieces, n) of the powers of u, which runs from 0 to 1 over each piece."""
    h = np.diff(trajectory.times)[:, None]
    v, a = trajectory.velocities, trajectory.accelerations
    c1, c2 = h * v[:-1], h * h * a[:-1] / 2
    # Difference between the end state and the first three powers, in position, velocity and acceleration.
    p_off = np.diff(trajectory.positions, axis=0) - c1 - c2
    v_off = h * v[1:] - c1 - 2 * c2
    a_off = h * h * a[1:] - 2 * c2
    c3 = 10 * p_off - 4 * v_off + a_off / 2
    c4 = -15 * p_off + 7 * v_off - a_off
    c5 = 6 * p_off - 3 * v_off + a_off / 2
    return np.stack([trajectory.positions[:-1], c1, c2, c3, c4, c5])
