"""Sampling of a trajectory at many times by the kernel, for measurements and proofs of planned motions.

The verifier evaluates the same quintics by ``Trajectory`` itself, without code of the kernel.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.geometry import Array
from pickcli.kernel import quintic_states
from pickcli.motion.trajectory import Trajectory


def states_at(trajectory: Trajectory, t: Array, highest: int = 2) -> Array:
    """Return positions and their time derivatives.

    Args:
        trajectory: N points with quintics in between.
        t: (M,) s; times outside of the trajectory are clamped to its ends.
        highest: Highest derivative, 0 to 2.

    Returns:
        (highest + 1, M, n) positions, velocities, accelerations.
    """
    at = trajectory
    return quintic_states(at.times, at.positions, at.velocities, at.accelerations, t, highest)


def divided(trajectory: Trajectory, parts: int) -> Trajectory:
    """Return a trajectory with more points on the same curve.

    Args:
        trajectory: N points with quintics in between.
        parts: Number of parts of each piece, at least 1.

    Returns:
        The same motion with (N - 1) parts + 1 points.
    """
    if parts == 1:
        return trajectory
    starts, lengths = trajectory.times[:-1], np.diff(trajectory.times)
    inner = (starts[:, None] + lengths[:, None] * np.arange(parts) / parts).reshape(-1)
    t = np.append(inner, trajectory.times[-1])
    positions, velocities, accelerations = states_at(trajectory, t)
    return replace(
        trajectory, times=t, positions=positions, velocities=velocities, accelerations=accelerations
    )
