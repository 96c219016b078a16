"""Whether the vacuum holds: the wrench on the cup, from gravity and motion, against what the cup bears."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.cup_limits import CupLimits
from pickcli.cell.item import Item
from pickcli.cell.tool import Tool
from pickcli.geometry import Array
from pickcli.kinematics.held_body import HeldBody
from pickcli.kinematics.tip_motion import TipMotion
from pickcli.motion.plan import Grasp


@dataclass(frozen=True)
class Load:
    """Worst load on the cup over a motion, each figure by itself but for the ratio.

    Attributes:
        pull: N along the cup's axis, away from it.
        shear: N across it.
        moment: Nm of bending, about the cup's tip.
        twist: Nm about the cup's axis.
        ratio: Of all figures at one time over what the cup bears; the cup holds up to 1.
    """

    pull: float
    shear: float
    moment: float
    twist: float
    ratio: float

    def of(self, grasp: Grasp) -> Grasp:
        """Note this load in a grasp.

        Args:
            grasp: The grasp.

        Returns:
            The grasp with this as the load of its motion.
        """
        return replace(
            grasp,
            moment=self.moment,
            pull=self.pull,
            shear=self.shear,
            twist=self.twist,
            load_ratio=self.ratio,
        )

    def __str__(self) -> str:
        return (
            f"pull {self.pull:.1f} N, shear {self.shear:.1f} N, moment {self.moment:.2f} Nm, "
            f"twist {self.twist:.2f} Nm"
        )


@dataclass(frozen=True, eq=False)
class Hold:
    """An item, as heavy as it may be, in the cup.

    Attributes:
        body: The item as a rigid body in the tool frame.
        limits: What the cup bears at full vacuum.
        vacuum_share: What the face under the cup keeps of full vacuum.
    """

    body: HeldBody
    limits: CupLimits
    vacuum_share: float

    @classmethod
    def of(cls, item: Item, face: str, T_tip_item: Array, tool: Tool) -> Hold:
        """An item held by one of its faces.

        Args:
            item: What is held.
            face: The name of the face under the cup.
            T_tip_item: (4, 4) the item in the tool frame.
            tool: The tool that holds it.

        Returns:
            The item with its mass and inertia as large as they may be.
        """
        R = T_tip_item[:3, :3]
        inertia = (1.0 + item.mass_error) * R @ item.inertia @ R.T
        body = HeldBody(item.heaviest, T_tip_item[:3, 3], inertia)
        return cls(body, tool.cup_limits, item.seals[face])

    def at_rest(self, R_world_tip: Array) -> Load:
        """The worst load at rest: no slower motion loads the cup less.

        Args:
            R_world_tip: (N, 3, 3) orientations of the tool frame.

        Returns:
            The worst load over the orientations.
        """
        return self._worst(self.body.weight(R_world_tip))

    def in_motion(self, motion: TipMotion) -> Load:
        """The worst load over the states of a motion in time.

        Args:
            motion: N states of the tool frame, derivatives by time in s.

        Returns:
            The worst load over the states.
        """
        return self._worst(self.body.wrench(motion))

    def _worst(self, wrenches: Array) -> Load:
        ratio = self.limits.ratio(wrenches, self.vacuum_share)
        return Load(
            pull=float(np.maximum(0.0, -wrenches[:, 2]).max()),
            shear=float(np.hypot(wrenches[:, 0], wrenches[:, 1]).max()),
            moment=float(np.hypot(wrenches[:, 3], wrenches[:, 4]).max()),
            twist=float(np.abs(wrenches[:, 5]).max()),
            ratio=float(ratio.max()),
        )
