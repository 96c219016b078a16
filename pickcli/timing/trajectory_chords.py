"""Chords near a trajectory, by which the kernel proves the timed motion itself."""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory


def trajectory_chords(trajectory: Trajectory) -> tuple[Array, Array]:
    """Compute chords of a trajectory, and bounds of how far its quintics leave them.

    For a piece with Bernstein coefficients b_i, its distance from the chord point at the same u is a convex
    combination of the distances of b_i from the chord at i / 5; the largest of those is a strict bound.

    Args:
        trajectory: N points with quintics in between.

    Returns:
        Chord ends (N, n) and slack (N - 1, n): each piece lies within its slack of its chord, joint by joint.
    """
    h, q = np.diff(trajectory.times)[:, None], trajectory.positions
    way, v, a = np.diff(q, axis=0), trajectory.velocities, trajectory.accelerations
    # b_1 to b_4 from both ends; b_0 and b_5 are the ends.
    first, last = (v[:-1] * h - way) / 5, (way - v[1:] * h) / 5
    off = np.abs([first, 2 * first + a[:-1] * h**2 / 20, 2 * last + a[1:] * h**2 / 20, last])
    return q, off.max(axis=0)


def swept_chords(trajectory: Trajectory, axis: int, low: Array, high: Array) -> tuple[Array, Array]:
    """Compute edges that cover a trajectory wherever it is displaced along one of its axes.

    Each piece is covered by one edge along the axis, from the least to the greatest position that it has
    there; all other joints are within their slack of the middle of the piece.

    Args:
        trajectory: N points with quintics in between.
        axis: Index of the axis.
        low: (N - 1,) rad or m, least displacement of each piece.
        high: (N - 1,) rad or m, greatest displacement.

    Returns:
        Ends (2 N - 2, n) of the edges, which are joined to one path, and slack (2 N - 3, n), none on what
        only joins them.
    """
    q, off = trajectory_chords(trajectory)
    middle, slack = (q[:-1] + q[1:]) / 2, np.abs(np.diff(q, axis=0)) / 2 + off
    ends = np.stack([middle, middle], axis=1)
    ends[:, 0, axis] += low - slack[:, axis]
    ends[:, 1, axis] += high + slack[:, axis]
    slack[:, axis] = 0.0
    ends[1::2] = ends[1::2, ::-1]  # back and forth, so that the edges between two pieces are short
    every = np.stack([slack, np.zeros_like(slack)], axis=1).reshape(-1, q.shape[1])
    return ends.reshape(-1, q.shape[1]), every[:-1]
