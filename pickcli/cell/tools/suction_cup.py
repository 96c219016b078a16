"""A suction cup as data: its size, how its bellows give way, how fast it may go, and what its seal bears."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from typing import Any

from pickcli.cell.device import DeviceKind
from pickcli.cell.tools.cup_limits import CupLimits


@dataclass(frozen=True, eq=False)
class SuctionCup:
    """The figures of a suction cup.

    Attributes:
        radius: m.
        stroke: m, how far the bellows compress.
        stiffness: N/m along the axis while relaxed.
        tilt: rad, how far from square on a face the lip still seals.
        limits: What the seal bears.
        contact_speed: m/s, fastest final approach.
        take_up: m of a lift in which the sealed cup gives way until it bears the item's weight.
        take_up_speed: m/s, fastest in that stretch where the weight bends the cup.
        seal_time: s at rest on the item before it is moved, for the vacuum to build up under the cup.
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

    @property
    def kind(self) -> str:
        """The kind of tool in words."""
        return "suction cup"

    @property
    def holder(self) -> str:
        """The word for what holds an item."""
        return "cup"

    @property
    def mover(self) -> DeviceKind:
        """What moves the joint of the cup, if it has one."""
        return DeviceKind.TOOL_ACTUATOR

    @property
    def holds_by_vacuum(self) -> bool:
        """Whether it holds by vacuum: yes."""
        return True

    @property
    def tip_radius(self) -> float:
        """That of the lip."""
        return self.radius

    @property
    def gives_way(self) -> float:
        """How far the bellows compress."""
        return self.stroke

    @property
    def takes_widths(self) -> bool:
        """False: the cup rests in the states that the cell names."""
        return False

    @property
    def finger_joints(self) -> tuple[str, ...]:
        """None: the joint of the cup is the last of the chain."""
        return ()

    @property
    def finger_links(self) -> tuple[str, ...]:
        """None: the cup is the last link of the chain."""
        return ()

    def joint_position(self, joint: str, stated: float) -> float:
        """Position of the joint of the cup, which is what the cell states.

        Args:
            joint: Its name.
            stated: rad or m.

        Returns:
            rad, or m of a prismatic joint.
        """
        return stated

    def motion_figures(self) -> dict[str, Any]:
        """The cup's size and how it gives way: stored motions do not depend on what it bears."""
        return {"cup": [self.radius, self.stroke, self.tilt]}

    def limit_figures(self) -> dict[str, Any]:
        """What the seal bears."""
        return {"cup limits": list(astuple(self.limits))}
