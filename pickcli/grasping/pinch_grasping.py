"""Pinch grasps: open fingers pass the item on both sides and close on it, and open from it, at rest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pickcli.cell.device import Device, device_of
from pickcli.cell.item import Item
from pickcli.cell.tool import MOVING, ToolState
from pickcli.cell.tools.gripper import ParallelGripper
from pickcli.collision.motion_segment import Mode
from pickcli.collision.stage_contacts import PickContacts
from pickcli.geometry import GRAVITY, Array
from pickcli.grasping.antipodal import limits_of, pinch_turns, width_of
from pickcli.grasping.envelope import Envelope
from pickcli.grasping.finger_envelopes import FingerReach, finger_envelopes
from pickcli.grasping.grasp_method import GraspMethod, GraspModes, GraspTimes
from pickcli.grasping.grasp_target import EXACT, CandidateSet, GraspTarget
from pickcli.grasping.holding import HoldLimits
from pickcli.grasping.pinch_candidates import pinches_in, sample_pinches
from pickcli.grasping.search import WIDE_SEARCH, Search
from pickcli.motion.plan import Grasp
from pickcli.motion.segment import SegmentKind
from pickcli.scene.scene import PoseNoise

NOTHING = 1e-9  # share of the limits left to pads that may be beside the item: over 0, as it divides the load


@dataclass(frozen=True, eq=False)
class PinchGrasping(GraspMethod):
    """Grasp method of a parallel gripper (see ``GraspMethod``).

    Attributes:
        gripper: The fingers of the tool.
    """

    gripper: ParallelGripper
    comes_in: ClassVar[SegmentKind] = SegmentKind.APPROACH
    closes_at_rest: ClassVar[bool] = True

    def may_hold(self, item: Item) -> bool:
        """Whether the fingers open wider than the least extent of an item, and bear its weight by friction.

        Args:
            item: The item.

        Returns:
            True if they do.
        """
        limits = self.gripper.limits
        bears = 2.0 * limits.friction * limits.force  # N, both pads together
        is_open = float(min(item.shape.extents)) < max(self.tool.positions.values())
        return is_open and item.heaviest * GRAVITY <= bears

    def envelopes(self, item: Item, depth: float) -> tuple[Envelope, ...]:
        """Return the envelopes in which the fingers enclose an item (see ``GraspMethod``).

        Args:
            item: The item.
            depth: m, from the front of the hand or lance to the tip.

        Returns:
            The envelopes, in the item's frame; () if there is none.
        """
        return finger_envelopes(item.shape, FingerReach.of(self.tool, self.gripper, depth))

    def sample(
        self, target: GraspTarget, rng: np.random.Generator, search: Search, most: float
    ) -> CandidateSet:
        """Sample pinches, each in every state of the tool that is wider than it (see ``GraspMethod``).

        Args:
            target: The item to be grasped.
            rng: Source of the random places.
            search: How many places and turns are tried.
            most: Largest share of what the pads bear that the item at rest may take up.

        Returns:
            Candidates, and why others were dropped.
        """
        return sample_pinches(target, self.tool, self.gripper, rng, search, most)

    def orientations(self, target: GraspTarget) -> Array:
        """Return the orientations of all pinches of an item, of the widest search.

        Args:
            target: The item to be grasped.

        Returns:
            (K, 3, 3) axes of the tool frame in the item's.
        """
        return pinch_turns(target.item.shape, target.way_in, WIDE_SEARCH.fan)

    def grasps_in(
        self, target: GraspTarget, envelope: Envelope, tool_state: ToolState, T_item_tip: Array, most: float
    ) -> CandidateSet:
        """Make pinches of poses in an envelope (see ``GraspMethod``).

        Args:
            target: The item to be grasped.
            envelope: One of its envelopes, or a part of one.
            tool_state: State in which the fingers pass the item.
            T_item_tip: (N, 4, 4) poses of the tool in the envelope, up to rounding.
            most: Largest share of what the pads bear that the item at rest may take up.

        Returns:
            Candidates in the envelope, and why others were dropped.
        """
        return pinches_in(target, self.tool, self.gripper, envelope, tool_state, T_item_tip, most)

    def bears(self, item: Item, face: str, T_item_tip: Array, noise: PoseNoise = EXACT) -> HoldLimits:
        """Return what the pads bear with every error of the item's pose, by the parts that touch the item.

        Args:
            item: The item.
            face: The name of the pinched faces.
            T_item_tip: (4, 4) pose of the tool at the grasp.
            noise: Bounds of the error of the pose in which the item is grasped.

        Returns:
            The limits.
        """
        limits = limits_of(self.gripper, item.shape, face, T_item_tip, noise)
        return HoldLimits(self.gripper.limits, NOTHING) if limits is None else HoldLimits(limits)

    def holding_state(self, face: str, tool_state: ToolState, item: Item) -> ToolState:
        """Return the width at which the pads rest on the item.

        Args:
            face: The name of the face under the cup, or of the pinched faces.
            tool_state: State of the tool that the item is grasped with.
            item: The item.

        Returns:
            The state.
        """
        return ToolState.of_width(width_of(item.shape, face))

    def contact_speed(self, contacts: PickContacts, grasp: Grasp) -> float | None:
        """Return the tool's contact speed: fingers close from both sides, and tip nothing.

        Args:
            contacts: The scene, and the target in it.
            grasp: Grasp of the target.

        Returns:
            m/s.
        """
        return self.tool.contact_speed

    def at_target(self, contacts: PickContacts, face: str, tool_state: ToolState) -> tuple[Mode, ...]:
        """Return the modes of open and of closing fingers.

        Args:
            contacts: Contacts of the pick.
            face: Unused: fingers touch nothing but the target.
            tool_state: State of the fingers that pass the target.

        Returns:
            Both modes.
        """
        return (
            Mode(tool_state, contacts=contacts.while_approaching()),
            Mode(MOVING, contacts=contacts.while_closing()),
        )

    def modes(self, contacts: PickContacts, grasp: Grasp, tool_excess: float) -> GraspModes:
        """Return the modes of a pinch: fingers hold the target in another state than that of the approach.

        Args:
            contacts: Contacts of the pick.
            grasp: Grasp of the target.
            tool_excess: Unused: fingers are not pressed on anything.

        Returns:
            The modes.
        """
        carrying = self.carrying(contacts, grasp.face, grasp.tool_state)
        approaching, closing = self.at_target(contacts, grasp.face, grasp.tool_state)
        lifting = Mode(carrying.tool_state, contacts=contacts.while_lifting_pinched())
        return GraspModes(approaching, closing, lifting, carrying)

    def rests(self, devices: Mapping[str, Device], release_time: float) -> GraspTimes:
        """Return the times in which the fingers move.

        Args:
            devices: Devices of the cell, by name.
            release_time: Unused: an item that is released by fingers does not move.

        Returns:
            The rests.
        """
        lead = device_of(devices, self.tool.mover).lead
        return GraspTimes(lead, lead)
