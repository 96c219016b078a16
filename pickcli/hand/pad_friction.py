"""Friction between one belt and one object: elastic up to the friction limit, perfectly plastic beyond it.

The force along the pad and across it and the torque about its normal lie within an ellipsoid, the limit
surface of soft fingers (Howe and Cutkosky, IJRR 15(6), 1996): the object sticks within it and slides on it.
The belt moves under the object: what slides is the difference of both.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pickcli.geometry import Array
from pickcli.hand.belt_hand import Belts

LEAST_RADIUS = 2e-3  # m, of the contact of a soft pad with an edge or a single point


@dataclass
class PadFriction:
    """The state of the friction of one belt on one object.

    Attributes:
        belts: Figures of the belts.
        friction: Coefficient between this belt and the object.
        stretch: (3,) how the surface is stretched: m along the pad, m across it, rad about its normal.
        is_sliding: Whether the limit was reached in the last step.
    """

    belts: Belts
    friction: float
    stretch: Array = field(default_factory=lambda: np.zeros(3))
    is_sliding: bool = False

    def load(self, rates: Array, normal_force: float, radius: float, dt: float) -> Array:
        """Advance by a step.

        Args:
            rates: (3,) of the object over the belt: m/s along the pad, m/s across it, rad/s about its normal.
            normal_force: N.
            radius: m, mean distance of the contact points from their middle.
            dt: s.

        Returns:
            (3,) N along the pad, N across it, and Nm about its normal, on the object.
        """
        radius = max(radius, LEAST_RADIUS)
        scale = np.array([1.0, 1.0, radius])  # a turn is judged by the way of the contact points
        stiffness = self.belts.stiffness * scale**2
        damping = self.belts.damping * scale**2
        stretch = self.stretch + rates * dt
        elastic = -stiffness * stretch
        limit = self.friction * normal_force
        share = float(np.linalg.norm(elastic / scale)) / limit if limit > 0.0 else np.inf
        self.is_sliding = share > 1.0
        if self.is_sliding:
            elastic = elastic / share
        self.stretch = -elastic / stiffness
        whole = elastic - damping * rates
        excess = float(np.linalg.norm(whole / scale)) / limit if limit > 0.0 else np.inf
        return np.asarray(whole / excess if excess > 1.0 else whole)


@dataclass
class BeltDrive:
    """The motor of one belt: a velocity loop of limited force.

    Attributes:
        belts: Figures of the belts.
        wanted: m/s, positive towards the palm.
        speed: m/s that it runs.
        force: N of the motor in the last step.
    """

    belts: Belts
    wanted: float = 0.0
    speed: float = 0.0
    force: float = 0.0

    def advance(self, load: float, dt: float) -> None:
        """Advance by a step.

        Args:
            load: N with which objects hold the belt back, against the direction towards the palm.
            dt: s.
        """
        needed = self.belts.mass * (self.wanted - self.speed) / dt + load
        self.force = min(max(needed, -self.belts.force), self.belts.force)
        self.speed += (self.force - load) / self.belts.mass * dt
