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
