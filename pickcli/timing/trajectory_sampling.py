"""States of a trajectory at many times, evaluated by the kernel: what planning measures on its own motions.

The second opinion evaluates the same quintics by ``Trajectory`` itself, with no code of the kernel.
"""

from __future__ import annotations

from pickcli.geometry import Array
from pickcli.kernel import quintic_states
from pickcli.motion.trajectory import Trajectory


def states_at(trajectory: Trajectory, t: Array, highest: int = 2) -> Array:
    """Positions and their derivatives by time.

    Args:
        trajectory: N points with quintics in between.
        t: (M,) s; times outside of the trajectory are clamped to its ends.
        highest: Highest derivative, 0 to 2.

    Returns:
        (highest + 1, M, n) positions, velocities, accelerations.
    """
    at = trajectory
    return quintic_states(at.times, at.positions, at.velocities, at.accelerations, t, highest)
