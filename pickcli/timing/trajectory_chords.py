"""Chords that a trajectory stays near, by which the kernel proves the timed motion itself."""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory

# Power basis of a quintic on [0, 1] to its Bernstein coefficients.
_BERNSTEIN = np.array(
    [
        [1, 0, 0, 0, 0, 0],
        [1, 1 / 5, 0, 0, 0, 0],
        [1, 2 / 5, 1 / 10, 0, 0, 0],
        [1, 3 / 5, 3 / 10, 1 / 10, 0, 0],
        [1, 4 / 5, 6 / 10, 4 / 10, 1 / 5, 0],
        [1, 1, 1, 1, 1, 1],
    ]
)


def trajectory_chords(trajectory: Trajectory) -> tuple[Array, Array]:
    """Chords of a trajectory, and how far its quintics leave them.

    With Bernstein coefficients b_i of a piece, its distance from the chord point at the same u is a convex
    combination of the distances of b_i from the chord at i / 5: the largest of those is a strict bound.

    Args:
        trajectory: N points with quintics in between.

    Returns:
        Chord ends (N, n) and slack (N - 1, n): each piece lies within its slack of its chord, joint by joint.
    """
    control = _BERNSTEIN @ trajectory.coefficients()
    q = trajectory.positions
    along = np.linspace(0.0, 1.0, 6)[None, :, None]
    chord = q[:-1, None] + along * (q[1:] - q[:-1])[:, None]
    return q, np.abs(control - chord).max(axis=1)
