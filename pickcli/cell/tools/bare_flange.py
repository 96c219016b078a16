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
        """The kind of tool in words: that there is none."""
        return "none"

    @property
    def holder(self) -> str:
        """What would hold an item, in a word."""
        return "flange"

    @property
    def limits(self) -> GripLimits:
        """What a hold bears at most. Raises InputError, for nothing can be held."""
        raise InputError(
            f"no suction cup is mounted on {self.flange_link}: picks need one; add `tool` to the cell"
        )

    @property
    def contact_speed(self) -> float:
        """The fastest final approach, m/s: infinite, as a flange meets nothing on purpose."""
        return np.inf

    @property
    def mover(self) -> DeviceKind:
        """The kind of device that would change the state of a tool."""
        return DeviceKind.TOOL_ACTUATOR

    @property
    def holds_by_vacuum(self) -> bool:
        """Whether it holds by vacuum: no."""
        return False

    @property
    def tip_radius(self) -> float:
        """Radius in m around the tip within which what is held begins: 0."""
        return 0.0

    @property
    def gives_way(self) -> float:
        """How far in m it gives way along its axis: 0."""
        return 0.0

    @property
    def stiffness(self) -> float:
        """N/m with which it gives way: infinite, it is rigid."""
        return np.inf

    @property
    def takes_widths(self) -> bool:
        """Whether the tool rests at widths between its states: no."""
        return False

    @property
    def finger_joints(self) -> tuple[str, ...]:
        """Names of the joints of fingers: there are none."""
        return ()

    @property
    def finger_links(self) -> tuple[str, ...]:
        """Names of the links of fingers: there are none."""
        return ()

    def joint_position(self, joint: str, stated: float) -> float:
        """Position of a joint that a state moves, as the cell states it.

        Args:
            joint: Name of a joint.
            stated: rad or m.

        Returns:
            ``stated``, rad or m.
        """
        return stated

    def motion_figures(self) -> dict[str, Any]:
        """What stored motions depend on, for fingerprints: nothing."""
        return {}

    def limit_figures(self) -> dict[str, Any]:
        """What the hold bears, for the hash of a scene: nothing."""
        return {}
