"""Sampling of a trajectory's states at many times by the kernel, for measurements on planned motions.

The verifier evaluates the same quintics by ``Trajectory`` itself, without code of the kernel.
"""

from __future__ import annotations

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
