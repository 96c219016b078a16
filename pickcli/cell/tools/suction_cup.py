"""A suction cup: size, stiffness of the bellows, speeds, and load limits of the seal."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from itertools import product
from typing import Any

import numpy as np

from pickcli.cell.device import DeviceKind
from pickcli.cell.item import REFERENCE_FLOW
from pickcli.cell.tools.cup_limits import CupLimits
from pickcli.cell.tools.lip_leak import kept_vacuum, open_area
from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class SuctionCup:
    """The figures of a suction cup.

    Attributes:
        radius: m.
        stroke: m, compression of the bellows.
        stiffness: N/m of the relaxed bellows along the axis.
        tilt: rad, largest angle to a face's normal at which the lip seals.
        limits: Load limits of the seal.
        contact_speed: m/s, largest speed of the final approach.
        take_up: m at the start of a lift in which the sealed cup stretches until it bears the item's weight.
        take_up_speed: m/s, largest speed in that stretch if the weight bends the cup.
        seal_time: s at rest on the item before it is moved, while the vacuum builds up under the cup.
        flow: l/min of free air that its pump draws.
    """

    radius: float
    stroke: float
    stiffness: float
    tilt: float
    limits: CupLimits
    contact_speed: float
    take_up: float
    take_up_speed: float
    seal_time: float
    flow: float = REFERENCE_FLOW

    @property
    def kind(self) -> str:
        """Kind of the tool in words."""
        return "suction cup"

    @property
    def holder(self) -> str:
        """Word for the part that holds an item."""
        return "cup"

    @property
    def mover(self) -> DeviceKind:
        """Kind of the device that moves the cup's joint, if there is one."""
        return DeviceKind.TOOL_ACTUATOR

    @property
    def holds_by_vacuum(self) -> bool:
        """True: it holds items by vacuum."""
        return True

    @property
    def tip_radius(self) -> float:
        """Radius of the lip, m."""
        return self.radius

    @property
    def gives_way(self) -> float:
        """Compression of the bellows, m."""
        return self.stroke

    @property
    def takes_widths(self) -> bool:
        """False: the cup rests only in the states named by the cell."""
        return False

    @property
    def finger_joints(self) -> tuple[str, ...]:
        """Empty: the cup's joint is part of the chain."""
        return ()

    @property
    def finger_links(self) -> tuple[str, ...]:
        """Empty: the cup is the last link of the chain."""
        return ()

    def kept_vacuum(self, seal: float, rooms: Array, off: float = 0.0) -> float:
        """Return the share of full vacuum under the cup on a face that may be narrower than the lip.

        Args:
            seal: Share that the face keeps under the whole lip.
            rooms: (A, 2) m from the middle of the lip to both edges of the face, along each of its axes.
            off: m by which the cup may be off that place, in any direction.

        Returns:
            A lower bound of the share.
        """
        if float(rooms.min()) - off >= self.radius:
            return seal
        aside = np.array([-off, off])
        ways = np.array([*product((-1.0, 0.0, 1.0), repeat=len(rooms))])
        shifted = rooms + ways[..., None] * aside  # along all axes at once: no direction opens more
        most = float(open_area(self.radius, shifted.reshape(len(ways), -1)).max())
        return kept_vacuum(seal, most, self.flow)

    def covered(self, rooms: Array, off: float = 0.0) -> float:
        """Return how far a face reaches under the lip, which is the lever of what the cup bears.

        Args:
            rooms: (A, 2) m from the middle of the lip to both edges of the face, along each of its axes.
            off: m by which the cup may be off that place along any axis.

        Returns:
            Share of the lip's radius, in [0, 1].
        """
        return float(np.clip((rooms.min() - off) / self.radius, 0.0, 1.0))

    def joint_position(self, joint: str, stated: float) -> float:
        """Return the position of the cup's joint, which is the stated one.

        Args:
            joint: Name of the joint.
            stated: rad or m.

        Returns:
            rad, or m of a prismatic joint.
        """
        return stated

    def motion_figures(self) -> dict[str, Any]:
        """Return size, stroke and tilt; stored motions do not depend on load limits."""
        return {"cup": [self.radius, self.stroke, self.tilt]}

    def limit_figures(self) -> dict[str, Any]:
        """Return the figures of the seal's load limits."""
        return {"cup limits": list(astuple(self.limits))}
