"""A parallel gripper: two fingers that mirror each other, pads, force and speeds.

The width of a gripper is the distance between its pads. Tool frame: origin in the middle between the pads, +z
out of the hand, y along the closing direction.
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
        side: +1 if its pad is on the +y side of the tool frame, else -1.
        opening_sign: +1 if its joint's position increases when the gripper opens, else -1.
    """

    link: str
    joint: str
    side: float
    opening_sign: float


@dataclass(frozen=True, eq=False)
class ParallelGripper:
    """The figures of a parallel gripper.

    Attributes:
        fingers: Both fingers; each moves by half of a change of width.
        pad: (a, b) m, sides of the pads along x and z of the tool frame.
        gap: m, width with both joints at 0.
        limits: Load limits of the closed gripper.
        closing_speed: m/s, rate of change of the width.
        contact_speed: m/s, largest speed of the final approach with a finger on either side of the item.
    """

    fingers: tuple[Finger, Finger]
    pad: tuple[float, float]
    gap: float
    limits: PinchLimits
    closing_speed: float
    contact_speed: float

    @property
    def kind(self) -> str:
        """Kind of the tool in words."""
        return "gripper"

    @property
    def holder(self) -> str:
        """Word for the part that holds an item."""
        return "gripper"

    @property
    def mover(self) -> DeviceKind:
        """Kind of the device that moves the fingers."""
        return DeviceKind.GRIPPER

    @property
    def holds_by_vacuum(self) -> bool:
        """False: the fingers hold by their positions."""
        return False

    @property
    def tip_radius(self) -> float:
        """Half of the longer side of a pad, m."""
        return max(self.pad) / 2

    @property
    def gives_way(self) -> float:
        """Compliant travel along the axis in m: 0, as the pads do not press along it."""
        return 0.0

    @property
    def stiffness(self) -> float:
        """Stiffness along the axis in N/m: infinite."""
        return np.inf

    @property
    def takes_widths(self) -> bool:
        """True: closed on an item, the fingers rest between two states."""
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
        """Return the geometry of fingers and pads; stored motions do not depend on load limits."""
        fingers = [[f.link, f.joint, [f.side, f.opening_sign]] for f in self.fingers]
        return {"gripper": [fingers, [*self.pad, self.gap]]}

    def limit_figures(self) -> dict[str, Any]:
        """Return the figures of the pads' load limits."""
        return {"pinch limits": [self.limits.force, self.limits.friction, *self.limits.pad]}

    def joint_position(self, joint: str, stated: float) -> float:
        """Compute the position of a finger's joint at a width.

        Args:
            joint: Name of the joint.
            stated: m between the pads.

        Returns:
            m.
        """
        finger = next(finger for finger in self.fingers if finger.joint == joint)
        return finger.opening_sign * (stated - self.gap) / 2

    def width_at(self, positions: Array) -> float:
        """Compute the width from the positions of the finger joints.

        Args:
            positions: (2,) m, of the joints of both fingers.

        Returns:
            m between the pads.
        """
        one, other = self.fingers
        return float(self.gap + one.opening_sign * positions[0] + other.opening_sign * positions[1])
