"""Holds: the wrench on cup or pads, from gravity and motion, compared with what they bear."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import astuple, dataclass, replace

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.tools.grip_model import GripLimits
from pickcli.geometry import GRAVITY, Array
from pickcli.kinematics.held_body import HeldBody
from pickcli.kinematics.tip_motion import TipMotion
from pickcli.motion.plan import Grasp


@dataclass(frozen=True)
class GripLoad:
    """Worst load on cup or pads over a motion, each component by itself except for the ratio.

    Attributes:
        pull: N along the cup's axis, away from it; for fingers along the closing axis, either way.
        shear: N across that axis.
        moment: Nm of bending, about the tip.
        twist: Nm about that axis.
        ratio: All components at one time over what cup or pads bear; they hold up to 1.
    """

    pull: float
    shear: float
    moment: float
    twist: float
    ratio: float

    @classmethod
    def worst(cls, loads: Iterable[GripLoad]) -> GripLoad:
        """Return the maximum of each component over several loads.

        Args:
            loads: The loads, at least one.

        Returns:
            The load over all of them.
        """
        return cls(*(max(figures) for figures in zip(*map(astuple, loads), strict=True)))

    def of(self, grasp: Grasp) -> Grasp:
        """Record this load in a grasp.

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
class HoldLimits:
    """What a tool bears for a grasp of an item.

    Attributes:
        limits: Limits of the cup at full vacuum, or of the pads as far as they touch the item.
        share: Usable share of the limits: the vacuum that the face under a cup keeps, 1 between pads.
    """

    limits: GripLimits
    share: float = 1.0


@dataclass(frozen=True, eq=False)
class Laden:
    """What lies on a held item, as a weight at any one of its corners, or nowhere.

    Attributes:
        mass: kg.
        corners: (8, 3) m in the tool frame, corners of the box around the item.
    """

    mass: float
    corners: Array

    @classmethod
    def of(cls, item: Item, T_tip_item: Array, mass: float) -> Laden:
        """Describe what lies on an item.

        Args:
            item: The held item.
            T_tip_item: (4, 4) pose of the item in the tool frame.
            mass: kg of all that lies on it.

        Returns:
            That mass, with the corners where it may rest.
        """
        signs = np.stack(np.meshgrid(*[(-1.0, 1.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
        corners = signs * item.shape.extents / 2 @ T_tip_item[:3, :3].T + T_tip_item[:3, 3]
        return cls(mass, corners)

    def wrenches(self, R_world_tip: Array) -> Array:
        """Return the further wrench of the cup on the item, at rest.

        Args:
            R_world_tip: (N, 3, 3) orientations of the tool frame.

        Returns:
            (9, N, 6) at the tip, in the tool frame: with the mass at each corner, and without it.
        """
        force = self.mass * GRAVITY * R_world_tip[:, 2]
        torques = np.cross(self.corners[:, None], force)
        laden = np.concatenate([np.broadcast_to(force, torques.shape), torques], axis=2)
        return np.concatenate([laden, np.zeros((1, len(force), 6))])


@dataclass(frozen=True, eq=False)
class Hold:
    """An item with its largest mass, in the cup or between the pads.

    Attributes:
        body: The item as a rigid body in the tool frame.
        limits: Limits of the cup at full vacuum, or of the pads as far as they touch the item.
        share: Usable share of the limits.
    """

    body: HeldBody
    limits: GripLimits
    share: float

    @classmethod
    def of(cls, item: Item, T_tip_item: Array, bears: HoldLimits) -> Hold:
        """Build the hold of an item.

        Args:
            item: The held item.
            T_tip_item: (4, 4) pose of the item in the tool frame.
            bears: What the tool bears for this grasp.

        Returns:
            The item with its largest mass and inertia.
        """
        R = T_tip_item[:3, :3]
        inertia = (1.0 + item.mass_error) * R @ item.inertia @ R.T
        body = HeldBody(item.heaviest, T_tip_item[:3, 3], inertia)
        return cls(body, bears.limits, bears.share)

    def at_rest(self, R_world_tip: Array) -> GripLoad:
        """Return the worst load at rest, which no slower motion can undercut.

        Args:
            R_world_tip: (N, 3, 3) orientations of the tool frame.

        Returns:
            The worst load over the orientations.
        """
        return self._worst(self.body.weight(R_world_tip))

    def ratios_at_rest(self, R_world_tip: Array, laden: Laden | None = None) -> Array:
        """Return the load at rest over what the cup bears.

        Args:
            R_world_tip: (N, 3, 3) orientations of the tool frame.
            laden: What lies on the item; None for nothing.

        Returns:
            (N,), with what lies on the item where that is worst.
        """
        own = self.body.weight(R_world_tip)
        wrenches = own[None] if laden is None else own + laden.wrenches(R_world_tip)
        return np.asarray(self.limits.ratio(wrenches, self.share).max(axis=0))

    def torque_at_rest(self, R_world_tip: Array) -> float:
        """Return the share of the limits that the torque of the weight takes, in bending or in twist.

        Args:
            R_world_tip: (3, 3) orientation of the tool frame.

        Returns:
            The larger share.
        """
        torque = self.body.weight(R_world_tip[None])[0, 3:]
        bending, twist = np.hypot(torque[0], torque[1]), abs(torque[2])
        return float(max(bending / self.limits.max_moment, twist / self.limits.max_twist) / self.share)

    def in_motion(self, motion: TipMotion) -> GripLoad:
        """Return the worst load over the states of a motion in time.

        Args:
            motion: N states of the tool frame, derivatives by time in s.

        Returns:
            The worst load over the states.
        """
        return self._worst(self.body.wrench(motion))

    def _worst(self, wrenches: Array) -> GripLoad:
        return _worst(wrenches[None], HoldLimits(self.limits, self.share))[0]


def loads_at_rest(
    item: Item, bears: HoldLimits, T_item_tip: Array, R_world_item: Array
) -> tuple[GripLoad, ...]:
    """Compute the loads at rest, for many tool poses at all of which the tool bears the same.

    Args:
        item: The held item.
        bears: What the tool bears there.
        T_item_tip: (P, 4, 4) poses of the tool.
        R_world_item: (3, 3) orientation of the item.

    Returns:
        For each pose the worst load over the item's current orientation and hanging straight down from the
        cup.
    """
    R, p = T_item_tip[:, :3, :3], T_item_tip[:, :3, 3]
    p_tip_com = -(p[:, None] @ R)
    upwards = np.stack([R_world_item[2] @ R, np.tile((0.0, 0.0, -1.0), (len(R), 1))], axis=1)
    force = item.heaviest * GRAVITY * upwards
    wrenches = np.concatenate([force, np.cross(p_tip_com, force)], axis=2)
    return _worst(wrenches, bears)


def _worst(wrenches: Array, bears: HoldLimits) -> tuple[GripLoad, ...]:
    """Return the worst load of each of many sets of wrenches (P, N, 6)."""
    ratio = bears.limits.ratio(wrenches, bears.share)
    figures = np.concatenate([bears.limits.figures(wrenches), ratio[None]])
    return tuple(GripLoad(*worst) for worst in figures.max(axis=2).T.tolist())
