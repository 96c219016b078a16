"""A flange on which nothing is mounted: it holds nothing, and says so to all that asks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from pickcli.cell.device import DeviceKind
from pickcli.cell.tools.grip_model import GripLimits
from pickcli.errors import InputError


@dataclass(frozen=True, eq=False)
class BareFlange:
    """What stands for a tool where a cell has none.

    Attributes:
        flange_link: The robot's last link.
    """

    flange_link: str

    @property
    def kind(self) -> str:
        """None."""
        return "none"

    @property
    def holder(self) -> str:
        """The flange."""
        return "flange"

    @property
    def limits(self) -> GripLimits:
        """Raises InputError: nothing is held."""
        raise InputError(
            f"no suction cup is mounted on {self.flange_link}: picks need one; add `tool` to the cell"
        )

    @property
    def contact_speed(self) -> float:
        """Without limit: it meets nothing by intent."""
        return np.inf

    @property
    def mover(self) -> DeviceKind:
        """The device that would turn a cup."""
        return DeviceKind.TOOL_ACTUATOR

    @property
    def holds_by_vacuum(self) -> bool:
        """False."""
        return False

    @property
    def tip_radius(self) -> float:
        """Nothing."""
        return 0.0

    @property
    def gives_way(self) -> float:
        """By nothing."""
        return 0.0

    @property
    def stiffness(self) -> float:
        """Rigid."""
        return np.inf

    @property
    def takes_widths(self) -> bool:
        """False."""
        return False

    @property
    def finger_joints(self) -> tuple[str, ...]:
        """None."""
        return ()

    @property
    def finger_links(self) -> tuple[str, ...]:
        """None."""
        return ()

    def joint_position(self, joint: str, stated: float) -> float:
        """What is stated.

        Args:
            joint: Name of a joint.
            stated: rad or m.

        Returns:
            The same.
        """
        return stated

    def motion_figures(self) -> dict[str, Any]:
        """None."""
        return {}

    def limit_figures(self) -> dict[str, Any]:
        """None."""
        return {}
