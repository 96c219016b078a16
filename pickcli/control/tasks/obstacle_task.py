"""Task that keeps the robot off what is near: velocity dampers on distances.

A distance d may shrink at most by gain (d - wanted) per s, so that it approaches what is wanted and never
passes it (Faverjon and Tournassoud, ICRA 1987; Kanoun et al., IEEE T-RO 27(4), 2011, section IV); and at most
at the rate from which the joints can still brake before it. Any spheres of the robot, boxes, cylinders,
spheres and points are such pairs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.collision.kernel_validator import KernelValidator
from pickcli.control.hierarchical_qp import BoundedRows
from pickcli.control.tasks.task import ControlState, Task, stopping_rate
from pickcli.geometry import Array
from pickcli.kernel import ContactKind

BRAKING = 0.25  # of the joints' deceleration that is counted on: other tasks need some of it


@dataclass(frozen=True, eq=False)
class ObstacleTask(Task):
    """Keeps distances of the robot from solids, and of its links from each other.

    Attributes:
        name: Name of the task in its stack.
        validator: The robot and the solids that it keeps off.
        wanted: m, distance that is kept from solids.
        between_links: m, distance that links keep from each other; some are near by design.
        influence: m, distance at which a pair begins to count.
        gain: 1/s.
        acceleration: (n,) rad/s^2 or m/s^2, of the joints.
    """

    name: str
    validator: KernelValidator
    wanted: float
    between_links: float
    influence: float
    gain: float
    acceleration: Array

    def rows(self, state: ControlState) -> BoundedRows:
        """Return the rows, one for each pair within the influence.

        Args:
            state: The robot now.

        Returns:
            (m, n) rows and their bounds, per s.
        """
        distances, gradients, parts = self.validator.kernel.near_pairs(state.q, self.influence)
        left = distances - np.where(parts[:, 1] == ContactKind.SELF, self.between_links, self.wanted)
        deceleration = BRAKING * np.abs(gradients) @ self.acceleration
        rate = stopping_rate(left, deceleration, state.period)
        return BoundedRows.at_most(
            -gradients, np.where(left > 0.0, np.minimum(self.gain * left, rate), self.gain * left)
        )

    def error(self, state: ControlState) -> float:
        """Return by how many m the least distance is below what is wanted of it.

        Args:
            state: The robot now.

        Returns:
            Its size, 0 where the task is met.
        """
        distances, _, parts = self.validator.kernel.near_pairs(state.q, self.influence)
        wanted = np.where(parts[:, 1] == ContactKind.SELF, self.between_links, self.wanted)
        return max(0.0, float(np.max(wanted - distances, initial=0.0)))
