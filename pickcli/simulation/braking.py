"""The quickest stop along the path that the drives' torque allows, step by step.

The planned limits of acceleration leave the motors a reserve; after a contact all of it is used. With the
path q(s), the motors need tau = M q' s'' + (what s' alone needs), which is linear in s'': the hardest
braking that keeps every motor within its torque follows in closed form (as in Bobrow, Dubowsky and Gibson,
1985). The path is not left.
"""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory
from pickcli.simulation.supervision import Dynamics

RESERVE = 0.9  # of the motors' largest torque: the position loop needs the rest
GENTLE = 1.0  # 1/s^2, braking where no s'' keeps all motors within their torque


class Braking:
    """Set points from where the robot is on a trajectory to a standstill on it.

    path_time: s on the trajectory of the present set point
    rate: ds/dt, 0 at standstill
    """

    def __init__(
        self, trajectory: Trajectory, path_time: float, rate: float, dynamics: Dynamics, forces: Array
    ) -> None:
        self._trajectory, self._dynamics, self._forces = trajectory, dynamics, RESERVE * forces
        self.path_time, self.rate = path_time, rate

    def advance(self, time_step: float, pivot: float) -> Array:
        """The next set point (n,). pivot: measured position of the cup's pivot joint, rad."""
        q, v, a = (self._trajectory.sample(self.path_time, k)[0] for k in range(3))
        change = self._hardest(q, v, a, pivot)
        before, self.rate = self.rate, max(0.0, self.rate + change * time_step)
        end = self._trajectory.duration
        self.path_time = min(self.path_time + 0.5 * (before + self.rate) * time_step, end)
        return np.asarray(self._trajectory.sample(self.path_time)[0])

    def back(self, time_step: float, rate: float) -> Array:
        """The set point (n,) after a step back along the path at a share of its pace."""
        self.path_time = max(0.0, self.path_time - rate * time_step)
        return np.asarray(self._trajectory.sample(self.path_time)[0])

    def _hardest(self, q: Array, v: Array, a: Array, pivot: float) -> float:
        """The least s'' that keeps all motors within their torque."""
        still = np.zeros(len(q) + 1)
        joints, along = np.append(q, pivot), np.append(v, 0.0)
        without = self._dynamics(joints, self.rate * along, self.rate**2 * np.append(a, 0.0))[:-1]
        per_unit = (self._dynamics(joints, still, along) - self._dynamics(joints, still, still))[:-1]
        slope = np.where(np.abs(per_unit) < 1e-9, 1e-9, per_unit)
        ends = np.array([(-self._forces - without) / slope, (self._forces - without) / slope])
        lowest, highest = float(ends.min(axis=0).max()), float(ends.max(axis=0).min())
        return min(lowest, -GENTLE) if lowest < highest else -GENTLE
