"""Load limits of a suction cup: limits on the wrench between cup and item.

The wrench is w = (fx, fy, fz, tx, ty, tz), force in N and torque in Nm that the cup exerts on the item, at
the tip of the uncompressed cup, in the tool frame (+z out of the cup, into the item). A hold fails in two
ways:

- *Separation of the lip.* The vacuum presses the lip onto the item. Pull reduces that pressure everywhere;
  bending reduces it on one side and increases it on the other. The lip lifts if the sum of both exceeds the
  pressure.
- *Slip.* Friction of the lip bears shear and twist together, inside an elliptic limit surface: S. Goyal,
  A. Ruina, J. Papadopoulos, "Planar sliding with dry friction", Wear 143 (1991); R. D. Howe and
  M. R. Cutkosky, "Practical force-motion models for sliding manipulation", IJRR 15(6), 1996. The same two
  constraints, with other shapes, are those of J. Mahler et al., "Dex-Net 3.0", ICRA 2018, section IV.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.geometry import Array

UNIFORM_DISC = 2.0 / 3.0  # largest torque over force times radius, by friction under uniform pressure


@dataclass(frozen=True)
class CupLimits:
    """Limits at full vacuum; they decrease in proportion to the vacuum that the seal keeps.

    Attributes:
        max_pull: N along the cup's axis, away from it.
        max_shear: N perpendicular to the axis.
        max_moment: Nm of bending, about any axis perpendicular to the cup's.
        max_twist: Nm about the cup's axis.
    """

    max_pull: float
    max_shear: float
    max_moment: float
    max_twist: float

    @property
    def bearer(self) -> str:
        """Subject of sentences about the load, for messages."""
        return "the cup bears"

    @property
    def bears_compression(self) -> bool:
        """True: a push into the cup increases the pressure of the lip."""
        return True

    def along_axis(self, wrench: Array) -> Array:
        """Return the wrench in axes whose last one is the cup's, which are those of the tool frame.

        Args:
            wrench: (..., 6) at the tip, in the tool frame.

        Returns:
            (..., 6), unchanged.
        """
        return wrench

    def peel(self, wrench: Array, vacuum_share: Array | float = 1.0) -> Array:
        """Compute the share of the lip's contact force that pull and bending use up.

        Args:
            wrench: (..., 6) at the tip, in the tool frame, exerted by the cup on the item.
            vacuum_share: Vacuum under the cup over full vacuum, a number or an array (...).

        Returns:
            (...) pull / max_pull + bending / max_moment over the share; the lip lifts above 1.
        """
        pull = np.maximum(0.0, -wrench[..., 2])
        bending = np.hypot(wrench[..., 3], wrench[..., 4])
        return _over(pull / self.max_pull + bending / self.max_moment, vacuum_share)

    def slip(self, wrench: Array, vacuum_share: Array | float = 1.0) -> Array:
        """Compute the share of the friction that shear and twist use up.

        Args:
            wrench: (..., 6) at the tip, in the tool frame, exerted by the cup on the item.
            vacuum_share: Vacuum under the cup over full vacuum, a number or an array (...).

        Returns:
            (...) length of (shear / max_shear, twist / max_twist) over the share; the lip slips above 1.
        """
        shear = np.hypot(wrench[..., 0], wrench[..., 1])
        return _over(np.hypot(shear / self.max_shear, wrench[..., 5] / self.max_twist), vacuum_share)

    def figures(self, wrench: Array) -> Array:
        """Compute the components of a wrench that the limits apply to.

        Args:
            wrench: (..., 6) at the tip, in the tool frame, exerted by the cup on the item.

        Returns:
            (4, ...) pull and shear in N, bending and twist in Nm.
        """
        pull, shear = np.maximum(0.0, -wrench[..., 2]), np.hypot(wrench[..., 0], wrench[..., 1])
        moment, twist = np.hypot(wrench[..., 3], wrench[..., 4]), np.abs(wrench[..., 5])
        return np.stack([pull, shear, moment, twist])

    def ratio(self, wrench: Array, vacuum_share: Array | float = 1.0) -> Array:
        """Compute the load on the cup over its limits; the cup holds up to 1.

        Homogeneous of degree 1 in the wrench, and the same for a wrench turned about the cup's axis.

        Args:
            wrench: (..., 6) at the tip, in the tool frame, exerted by the cup on the item.
            vacuum_share: Vacuum under the cup over full vacuum, a number or an array (...).

        Returns:
            (...) the larger of ``peel`` and ``slip``, >= 0; infinite without vacuum.
        """
        return np.maximum(self.peel(wrench, vacuum_share), self.slip(wrench, vacuum_share))


def twist_of(max_shear: float, cup_radius: float) -> float:
    """Estimate the limit of twist if the cell states none, by the friction of a uniformly pressed disc.

    Args:
        max_shear: N.
        cup_radius: m.

    Returns:
        Nm.
    """
    return UNIFORM_DISC * max_shear * cup_radius


def _over(load: Array, share: Array | float) -> Array:
    """Quotient of load and share, infinite where the share is not positive."""
    if isinstance(share, float):  # called every millisecond in simulation
        return np.asarray(load / share if share > 0.0 else np.full_like(load, np.inf))
    share = np.asarray(share, dtype=np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(share > 0.0, load / share, np.inf))
