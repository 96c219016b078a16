"""A flange without a tool, as a grip model that cannot hold items."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from pickcli.cell.device import DeviceKind
from pickcli.cell.tools.grip_model import GripLimits
from pickcli.errors import InputError


@dataclass(frozen=True, eq=False)
class BareFlange:
    """Grip model of a cell without a tool.

    Attributes:
        flange_link: The robot's last link.
    """

    flange_link: str

    @property
    def kind(self) -> str:
        """Kind of the tool in words: none."""
        return "none"

    @property
    def holder(self) -> str:
        """Word for the link in messages."""
        return "flange"

    @property
    def limits(self) -> GripLimits:
        """Limits of a hold. Raises InputError, as nothing can be held."""
        raise InputError(
            f"no suction cup is mounted on {self.flange_link}: picks need one; add `tool` to the cell"
        )

    @property
    def contact_speed(self) -> float:
        """Largest speed of the final approach, m/s: infinite, as a flange makes no planned contact."""
        return np.inf

    @property
    def mover(self) -> DeviceKind:
        """Kind of device that would change a tool's state."""
        return DeviceKind.TOOL_ACTUATOR

    @property
    def holds_by_vacuum(self) -> bool:
        """Whether it holds items by vacuum: False."""
        return False

    @property
    def tip_radius(self) -> float:
        """Radius in m around the tip in which a held item may begin: 0."""
        return 0.0

    @property
    def gives_way(self) -> float:
        """Compliant travel along the axis in m: 0."""
        return 0.0

    @property
    def stiffness(self) -> float:
        """Stiffness along the axis in N/m: infinite."""
        return np.inf

    @property
    def takes_widths(self) -> bool:
        """Whether the tool can rest at widths between its states: False."""
        return False

    @property
    def finger_joints(self) -> tuple[str, ...]:
        """Names of finger joints: none."""
        return ()

    @property
    def finger_links(self) -> tuple[str, ...]:
        """Names of finger links: none."""
        return ()

    def joint_position(self, joint: str, stated: float) -> float:
        """Return the position of a joint, which is the stated one.

        Args:
            joint: Name of a joint.
            stated: rad or m.

        Returns:
            ``stated``, rad or m.
        """
        return stated

    def motion_figures(self) -> dict[str, Any]:
        """Return the figures that stored motions depend on, for fingerprints: none."""
        return {}

    def limit_figures(self) -> dict[str, Any]:
        """Return the figures of the limits, for the hash of a scene: none."""
        return {}
