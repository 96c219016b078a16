"""Bounds of polynomials by their Bernstein form: a curve never leaves the hull of its control points,
and never travels farther than along them. Exact where it counts, and never on the wrong side.
"""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory

RELATIVE = 1e-9  # how far above the true maximum a bound may lie
MOST_PIECES = 100_000  # that may hold a maximum; with more the bound is what it is, still from above


def control_points(trajectory: Trajectory, derivative: int) -> Array:
    """Bernstein control points (pieces, 6 - derivative, n) of a time derivative (0 to 3) of each piece."""
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
    """From each control point of every quintic to its next, (5, pieces, n).

    p, v, a: (pieces + 1, n) at the knots. h: (pieces, 1) s between them. Of positions only differences enter:
    over the third power of a few ms, what rounds at a radian would be seen in the jerk.
    """
    start, end = h * v[:-1] / 5, h * v[1:] / 5
    bent_start, bent_end = start + h * h * a[:-1] / 20, end - h * h * a[1:] / 20
    middle = np.diff(p, axis=0) - start - bent_start - bent_end - end
    return np.stack([start, bent_start, middle, bent_end, end])


def largest(points: Array) -> Array:
    """Largest value (n,) of the polynomials with control points (P, d + 1, n) over their pieces.

    From above, and within RELATIVE of the true value but for curves made to defy it: pieces that cannot
    hold the maximum drop out, the others are halved; the hull shrinks with the square of their length.
    """
    return np.array([_largest(points[:, :, j]) for j in range(points.shape[2])])


def _largest(points: Array) -> float:
    attained = -np.inf
    for _ in range(60):
        attained = max(attained, float(points[:, [0, -1]].max()))
        bounds = points.max(axis=1)
        slack = RELATIVE * max(1e-6, abs(attained))
        points = points[bounds > attained + slack]
        if len(points) == 0:
            return attained + slack
        if len(points) > MOST_PIECES:
            break
        points = np.concatenate(_halves(points))
    return max(attained, float(points.max()))


def _halves(points: Array) -> tuple[Array, Array]:
    """Both halves of polynomials (P, d + 1) by de Casteljau's algorithm."""
    left, right = [points[:, 0]], [points[:, -1]]
    while points.shape[1] > 1:
        points = (points[:, :-1] + points[:, 1:]) / 2
        left.append(points[:, 0])
        right.append(points[:, -1])
    return np.stack(left, axis=1), np.stack(right[::-1], axis=1)


def variation(trajectory: Trajectory, times: Array) -> Array:
    """How far each joint travels, at most, between consecutive times: (len(times) - 1, n), rad or m.

    times: strictly increasing, with every knot of the trajectory among them, so that each stretch is one
    quintic; its way is at most that along its control points.
    """
    p, v, a = (trajectory.sample(times, derivative) for derivative in range(3))
    return np.asarray(np.abs(_legs(p, v, a, np.diff(times)[:, None])).sum(axis=0))
