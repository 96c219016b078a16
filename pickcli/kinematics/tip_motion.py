"""Motion of the tool frame for moving joints: twist and acceleration, velocity products included."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class TipMotion:
    """Motion of the tool frame at N states; all vectors in world axes.

    Derivatives are by the same variable as those of the joints: time in s, or the parameter of a path.

    Attributes:
        poses: (N, 4, 4) T_world_tip.
        velocity: (N, 3) m of the frame's origin.
        angular_velocity: (N, 3) rad.
        acceleration: (N, 3) m of the frame's origin.
        angular_acceleration: (N, 3) rad.
    """

    poses: Array
    velocity: Array
    angular_velocity: Array
    acceleration: Array
    angular_acceleration: Array

    def at_rest(self) -> TipMotion:
        """Return the motion of a tip at rest at each of these poses.

        Returns:
            A motion whose velocities and accelerations are zero.
        """
        zero = np.zeros_like(self.velocity)
        return TipMotion(self.poses, zero, zero, zero, zero)
