"""A parallel gripper as data: two fingers that mirror each other, their pads, how hard and fast they close.

The width of a gripper is the distance between its pads. The tool frame sits between them: its origin in the
middle of the pads, +z out of the hand, y along which the fingers close.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from pickcli.cell.device import DeviceKind
from pickcli.cell.tools.pinch_limits import PinchLimits
from pickcli.geometry import Array


@dataclass(frozen=True)
class Finger:
    """One of the two fingers.

    Attributes:
        link: Name of its link.
        joint: Name of the prismatic joint that moves it in the hand.
        side: +1 if its pad is on the +y side of the tool frame, -1 on the other.
        opening: +1 if its joint's position grows as the gripper opens, else -1.
    """

    link: str
    joint: str
    side: float
    opening: float


@dataclass(frozen=True, eq=False)
class ParallelGripper:
    """The figures of a parallel gripper.

    Attributes:
        fingers: Both fingers; each moves by half of what the width changes.
        pad: (a, b) m, sides of the pads along x and z of the tool frame.
        gap: m, width at which both joints stand at 0.
        limits: What the pads bear when they are closed on something.
        closing_speed: m/s at which the width changes.
        contact_speed: m/s, fastest final approach, the fingers on either side of the item.
    """

    fingers: tuple[Finger, Finger]
    pad: tuple[float, float]
    gap: float
    limits: PinchLimits
    closing_speed: float
    contact_speed: float

    @property
    def kind(self) -> str:
        """The kind of tool in words."""
        return "gripper"

    @property
    def holder(self) -> str:
        """The word for what holds an item."""
        return "gripper"

    @property
    def mover(self) -> DeviceKind:
        """What moves the fingers."""
        return DeviceKind.GRIPPER

    @property
    def holds_by_vacuum(self) -> bool:
        """False: the fingers hold by where they stand."""
        return False

    @property
    def tip_radius(self) -> float:
        """The longer half of a pad."""
        return max(self.pad) / 2

    @property
    def gives_way(self) -> float:
        """How far in m it gives way along its axis: 0, as pads close on an item and press on nothing."""
        return 0.0

    @property
    def stiffness(self) -> float:
        """N/m with which it gives way along its axis: infinite."""
        return np.inf

    @property
    def takes_widths(self) -> bool:
        """True: on an item the fingers stand between open and closed."""
        return True

    @property
    def finger_joints(self) -> tuple[str, ...]:
        """Names of the joints of both fingers."""
        return tuple(finger.joint for finger in self.fingers)

    @property
    def finger_links(self) -> tuple[str, ...]:
        """Names of the links of both fingers."""
        return tuple(finger.link for finger in self.fingers)

    def motion_figures(self) -> dict[str, Any]:
        """Where the pads go with the joints: stored motions do not depend on what they bear."""
        fingers = [[f.link, f.joint, [f.side, f.opening]] for f in self.fingers]
        return {"gripper": [fingers, [*self.pad, self.gap]]}

    def limit_figures(self) -> dict[str, Any]:
        """What the pads bear."""
        return {"pinch limits": [self.limits.force, self.limits.friction, *self.limits.pad]}

    def joint_position(self, joint: str, stated: float) -> float:
        """Position of a finger's joint at a width.

        Args:
            joint: Name of the joint.
            stated: m between the pads.

        Returns:
            m.
        """
        finger = next(finger for finger in self.fingers if finger.joint == joint)
        return finger.opening * (stated - self.gap) / 2

    def width_at(self, positions: Array) -> float:
        """The width where the fingers' joints stand.

        Args:
            positions: (2,) m, of the joints of both fingers.

        Returns:
            m between the pads.
        """
        one, other = self.fingers
        return float(self.gap + one.opening * positions[0] + other.opening * positions[1])
