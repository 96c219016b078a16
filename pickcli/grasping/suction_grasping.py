"""Suction grasps: a cup is pressed on a face of the item, rests there until it seals, and lifts the item."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pickcli.cell.device import Device
from pickcli.cell.item import Item
from pickcli.cell.tool import ToolState
from pickcli.collision.motion_segment import Mode
from pickcli.collision.stage_contacts import PickContacts
from pickcli.geometry import Array
from pickcli.grasping.cup_envelopes import cup_envelopes
from pickcli.grasping.cup_press import cup_press, outward_of, overtravels
from pickcli.grasping.envelope import Envelope
from pickcli.grasping.grasp_method import GraspMethod, GraspModes, GraspTimes
from pickcli.grasping.grasp_target import EXACT, CandidateSet, GraspTarget
from pickcli.grasping.holding import HoldLimits
from pickcli.grasping.lip_coverage import bearing_share, lip_on
from pickcli.grasping.press_check import contact_speed
from pickcli.grasping.search import Search
from pickcli.grasping.suction_candidates import sample_suctions, suctions_in
from pickcli.grasping.surfaces import faces
from pickcli.motion.plan import Grasp
from pickcli.motion.segment import SegmentKind
from pickcli.scene.scene import PoseNoise


@dataclass(frozen=True, eq=False)
class SuctionGrasping(GraspMethod):
    """Grasp method of a suction cup (see ``GraspMethod``)."""

    comes_in: ClassVar[SegmentKind] = SegmentKind.CONTACT
    closes_at_rest: ClassVar[bool] = False

    @property
    def take_up(self) -> float:
        """Path in m over which the sealed bellows give way."""
        return self.tool.cup.take_up

    @property
    def take_up_speed(self) -> float:
        """Speed limit in m/s while the cup takes up the weight, as the cell states it."""
        return self.tool.cup.take_up_speed

    def may_hold(self, item: Item) -> bool:
        """Whether an item is suitable for suction.

        Args:
            item: The item.

        Returns:
            True if it has a face that the cup can be put on and that seals.
        """
        return item.suction and bool(faces(item, self.tool))

    def envelopes(self, item: Item, depth: float) -> tuple[Envelope, ...]:
        """Return the envelopes in which the cup seals on an item (see ``GraspMethod``).

        Args:
            item: The item.
            depth: m, from the front of the hand or lance to the tip.

        Returns:
            The envelopes, in the item's frame; () if there is none.
        """
        return cup_envelopes(item, self.tool)

    def sample(
        self, target: GraspTarget, rng: np.random.Generator, search: Search, most: float
    ) -> CandidateSet:
        """Sample places of the cup on the faces of an item (see ``GraspMethod``).

        Args:
            target: The item to be grasped.
            rng: Source of the random places.
            search: How many places, turns and tilts are tried.
            most: Largest share of what the cup bears that the item at rest may take up.

        Returns:
            Candidates, and why others were dropped.
        """
        return sample_suctions(target, self.tool, rng, search, most)

    def grasps_in(
        self, target: GraspTarget, envelope: Envelope, tool_state: ToolState, T_item_tip: Array, most: float
    ) -> CandidateSet:
        """Put the cup on a face at poses in its envelope (see ``GraspMethod``).

        Args:
            target: The item to be grasped.
            envelope: One of its envelopes, or a part of one.
            tool_state: State of the tool.
            T_item_tip: (N, 4, 4) poses of the tool in the envelope, up to rounding.
            most: Largest share of what the cup bears that the item at rest may take up.

        Returns:
            Candidates in the envelope, and why others were dropped.
        """
        return suctions_in(target, self.tool, envelope, tool_state, T_item_tip, most)

    def bears(self, item: Item, face: str, T_item_tip: Array, noise: PoseNoise = EXACT) -> HoldLimits:
        """Return what the cup bears at the vacuum that a face keeps.

        Args:
            item: The item.
            face: The name of the face under the cup.
            T_item_tip: (4, 4) pose of the tool at the grasp.
            noise: Bounds of the item's pose error; without effect where the whole lip is on the face.

        Returns:
            The limits.
        """
        cup = self.tool.cup
        return HoldLimits(cup.limits, bearing_share(item, face, lip_on(item, face, T_item_tip), cup, noise))

    def holding_state(self, face: str, tool_state: ToolState, item: Item) -> ToolState:
        """Return the state in which the cup approached.

        Args:
            face: The name of the face under the cup, or of the pinched faces.
            tool_state: State of the tool that the item is grasped with.
            item: The item.

        Returns:
            The state.
        """
        return tool_state

    def contact_speed(self, contacts: PickContacts, grasp: Grasp) -> float | None:
        """Return the highest speed at which the cup may meet the target (see ``press_check``).

        Args:
            contacts: The scene, the target in it, and its support.
            grasp: Grasp of the target.

        Returns:
            m/s; None if the cup tips the target at any useful speed.
        """
        return contact_speed(contacts, self.tool, grasp)

    def overtravel(self, face: str, T_item_tip: Array, noise: PoseNoise) -> Array:
        """Return how far the cup is pressed on the face (see ``cup_press``).

        Args:
            face: Face under the cup.
            T_item_tip: (N, 4, 4) poses of the tool at grasps on it.
            noise: Bounds of the target's pose error.

        Returns:
            (N,) m along the cup's axis.
        """
        return overtravels(face, T_item_tip, self.tool, noise)

    def at_target(self, contacts: PickContacts, face: str, tool_state: ToolState) -> tuple[Mode, ...]:
        """Return the mode of a cup that is pressed on, at any depth.

        Args:
            contacts: Contacts of the pick.
            face: The name of the face under the cup.
            tool_state: State of the tool that the target is grasped with.

        Returns:
            One mode.
        """
        outward = outward_of(face, contacts.target.T_world_item[:3, :3])
        return (Mode(tool_state, contacts=contacts.tool_while_pressing(outward, face)),)

    def modes(self, contacts: PickContacts, grasp: Grasp, tool_excess: float) -> GraspModes:
        """Return the modes of a suction grasp, all in the grasp's tool state.

        Args:
            contacts: Contacts of the pick.
            grasp: Grasp of the target.
            tool_excess: m by which the model of the cup is larger than the cup.

        Returns:
            The modes.
        """
        R_world_item = contacts.target.T_world_item[:3, :3]
        noise = contacts.scene.noise_of(contacts.target)
        press = cup_press(grasp, self.tool, noise, R_world_item, tool_excess)
        return GraspModes(
            approaching=Mode(grasp.tool_state, contacts=contacts.while_approaching(grasp.face)),
            taking=Mode(grasp.tool_state, contacts=contacts.while_pressing(press)),
            lifting=Mode(grasp.tool_state, contacts=contacts.while_lifting(press)),
            carrying=self.carrying(contacts, grasp.face, grasp.tool_state),
        )

    def rests(self, devices: Mapping[str, Device], release_time: float) -> GraspTimes:
        """Return the rests: until the cup has sealed, and until the item has come off the cup.

        Args:
            devices: Devices of the cell, by name.
            release_time: s that an item takes to come off the cup.

        Returns:
            The rests.
        """
        return GraspTimes(self.tool.cup.seal_time, release_time)
