"""Bounds of polynomials by their Bernstein form: a curve never leaves the hull of its control points,
and never travels farther than along them. Exact where it counts, and never on the wrong side.
"""

from __future__ import annotations

from math import comb

import numpy as np

from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory

RELATIVE = 1e-9  # how far above the true maximum a bound may lie
MOST_PIECES = 100_000  # that may hold a maximum; with more the bound is what it is, still from above


def control_points(trajectory: Trajectory, derivative: int) -> Array:
    """Bernstein control points (pieces, 6 - derivative, n) of a time derivative (0 to 3) of each piece."""
    powers = trajectory.coefficients()
    h = np.diff(trajectory.times)[:, None, None]
    for _ in range(derivative):
        powers = powers[:, 1:] * np.arange(1, powers.shape[1])[:, None] / h
    return np.asarray(np.einsum("ik,pkn->pin", _power_to_bernstein(powers.shape[1] - 1), powers))


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
    h = np.diff(times)[:, None]
    points = np.stack(
        [
            p[:-1],
            p[:-1] + h * v[:-1] / 5,
            p[:-1] + 2 * h * v[:-1] / 5 + h * h * a[:-1] / 20,
            p[1:] - 2 * h * v[1:] / 5 + h * h * a[1:] / 20,
            p[1:] - h * v[1:] / 5,
            p[1:],
        ]
    )
    return np.asarray(np.abs(np.diff(points, axis=0)).sum(axis=0))


def _power_to_bernstein(degree: int) -> Array:
    """(d + 1, d + 1): row i gives control point i of a polynomial with power coefficients c_k."""
    d = degree
    return np.array(
        [[comb(i, k) / comb(d, k) if k <= i else 0.0 for k in range(d + 1)] for i in range(d + 1)]
    )
