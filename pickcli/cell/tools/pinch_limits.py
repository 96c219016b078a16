"""Load limits of two finger pads: limits on the wrench between a parallel gripper and the item.

The wrench is w = (fx, fy, fz, tx, ty, tz), force in N and torque in Nm that the pads exert on the item, about
the middle between the pads, in the tool frame: z out of the hand, y along the closing direction. Both pads
press with the same force F, evenly over a rectangle of a x b. A hold fails in two ways:

- *Slip.* Friction of both pads bears shear along them and twist about y together, inside an elliptic limit
  surface. Each pad is a soft finger: its friction bears a twist of mu F times the mean distance of its points
  from its middle. S. Goyal, A. Ruina, J. Papadopoulos, "Planar sliding with dry friction", Wear 143 (1991);
  R. D. Howe and M. R. Cutkosky, "Practical force-motion models for sliding manipulation", IJRR 15(6), 1996.
- *Opening.* A force along y shifts pressure from one pad to the other, and a torque across y shifts it
  towards an edge of each pad, by at most F b / 2 per pad, with b the pad's shorter side. A pad lifts if both
  together exceed its pressure.

If the item's centre may be elsewhere than the torque assumes, the force there has further lever arms
(``stray``), each counted where it adds most.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.geometry import Array

N_PADS = 2


@dataclass(frozen=True)
class PinchLimits:
    """Limits of a closed parallel gripper.

    Attributes:
        force: N with which each pad presses.
        friction: Coefficient of friction between pad and item.
        pad: (a, b) m, sides of the pads along x and z of the tool frame.
        stray: m along x, y and z of the tool frame by which the item's centre may be off from the middle of
            what touches, besides the offset that a wrench about the tip includes.
    """

    force: float
    friction: float
    pad: tuple[float, float]
    stray: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def bearer(self) -> str:
        """Subject of sentences about the load, for messages."""
        return "the pads bear"

    @property
    def bears_compression(self) -> bool:
        """False: a push along the axis loads one pad as a pull loads the other."""
        return False

    @property
    def max_shear(self) -> float:
        """Limit of shear along the pads, N in any direction."""
        return N_PADS * self.friction * self.force

    @property
    def max_twist(self) -> float:
        """Limit of twist, Nm about the closing direction."""
        return self.max_shear * mean_distance(*self.pad)

    @property
    def max_pull(self) -> float:
        """Limit of force along the closing direction, N either way."""
        return N_PADS * self.force

    @property
    def max_moment(self) -> float:
        """Limit of bending, Nm about any axis perpendicular to the closing direction."""
        return N_PADS * self.force * min(self.pad) / 2

    def along_axis(self, wrench: Array) -> Array:
        """Return the wrench in axes whose last one is the closing direction.

        Args:
            wrench: (..., 6) about the tip, in the tool frame.

        Returns:
            (..., 6) in the axes z, x, y of the tool frame.
        """
        return np.asarray(wrench[..., [2, 0, 1, 5, 3, 4]])

    def peel(self, wrench: Array, share: Array | float = 1.0) -> Array:
        """Compute the share of a pad's pressure that force along y and bending use up.

        Args:
            wrench: (..., 6) about the tip, in the tool frame, exerted by the pads on the item.
            share: Usable share of the limits.

        Returns:
            (...) |fy| / max_pull + bending / max_moment over the share; a pad lifts above 1.
        """
        torque = self._torque(wrench)
        bending = np.hypot(torque[..., 0], torque[..., 2])
        return np.asarray((np.abs(wrench[..., 1]) / self.max_pull + bending / self.max_moment) / share)

    def slip(self, wrench: Array, share: Array | float = 1.0) -> Array:
        """Compute the share of the friction that shear and twist use up.

        Args:
            wrench: (..., 6) about the tip, in the tool frame, exerted by the pads on the item.
            share: Usable share of the limits.

        Returns:
            (...) length of (shear / max_shear, twist / max_twist) over the share; the pads slip above 1.
        """
        shear = np.hypot(wrench[..., 0], wrench[..., 2])
        twist = self._torque(wrench)[..., 1]
        return np.asarray(np.hypot(shear / self.max_shear, twist / self.max_twist) / share)

    def figures(self, wrench: Array) -> Array:
        """Compute the components of a wrench that the limits apply to.

        Args:
            wrench: (..., 6) about the tip, in the tool frame, exerted by the pads on the item.

        Returns:
            (4, ...) force along y and shear in N, bending and twist in Nm.
        """
        shear, bending = np.hypot(wrench[..., 0], wrench[..., 2]), np.hypot(wrench[..., 3], wrench[..., 5])
        return np.stack([np.abs(wrench[..., 1]), shear, bending, np.abs(wrench[..., 4])])

    def ratio(self, wrench: Array, share: Array | float = 1.0) -> Array:
        """Compute the load on the pads over their limits; they hold up to 1.

        Homogeneous of degree 1 in the wrench.

        Args:
            wrench: (..., 6) about the tip, in the tool frame, exerted by the pads on the item.
            share: Usable share of the limits.

        Returns:
            (...) the larger of ``peel`` and ``slip``, >= 0.
        """
        return np.maximum(self.peel(wrench, share), self.slip(wrench, share))

    def _torque(self, wrench: Array) -> Array:
        """Return the largest absolute torques (..., 3) about x, y and z, wherever the centre may be."""
        x, y, z = np.moveaxis(np.abs(wrench[..., :3]), -1, 0)
        by_x, by_y, by_z = self.stray
        levers = np.stack([by_y * z + by_z * y, by_x * z + by_z * x, by_x * y + by_y * x], axis=-1)
        return np.asarray(np.abs(wrench[..., 3:]) + levers)


def mean_distance(a: float, b: float) -> float:
    """Compute the mean distance of a rectangle's points from its centre.

    Args:
        a: m, one side.
        b: m, the other.

    Returns:
        m; 0.3826 a for a square.
    """
    d = np.hypot(a, b)
    ends = a**2 / b * np.log((b + d) / a) + b**2 / a * np.log((a + d) / b)
    return float(d / 6 + ends / 12)
