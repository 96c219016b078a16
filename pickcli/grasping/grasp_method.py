"""Interface of picks to a kind of tool: its grasps, how it approaches an item, what it bears.

Suction and the pinch of two fingers differ in the same few ways everywhere in the planning of a pick. Each is
one class with these methods; only `method_choice` distinguishes kinds of tools.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from pickcli.cell.device import Device
from pickcli.cell.item import Item
from pickcli.cell.tool import Tool, ToolState
from pickcli.collision.attached_item import AttachedItem
from pickcli.collision.motion_segment import Mode
from pickcli.collision.stage_contacts import PickContacts
from pickcli.geometry import Array, inverse
from pickcli.grasping.envelope import Envelope
from pickcli.grasping.grasp_target import EXACT, CandidateSet, GraspTarget
from pickcli.grasping.holding import Hold, HoldLimits
from pickcli.grasping.search import Search
from pickcli.motion.plan import Grasp
from pickcli.motion.segment import SegmentKind
from pickcli.scene.scene import PoseNoise


@dataclass(frozen=True)
class GraspTimes:
    """Durations for which the arm rests when the tool grasps and when it releases an item.

    Attributes:
        taking: s.
        releasing: s.
    """

    taking: float
    releasing: float


@dataclass(frozen=True)
class ContactLimit:
    """Speed limit for a tool that approaches an item.

    Attributes:
        kind: Kind of the segment to which it applies: the contact for a cup; the approach for fingers, which
            pass the item on both sides.
        speed: m/s.
    """

    kind: SegmentKind
    speed: float


@dataclass(frozen=True)
class GraspModes:
    """Modes of the segments of a grasp.

    Attributes:
        approaching: For the empty tool on its way to the item, or away from it.
        taking: For the empty tool at the item: a cup that is pressed on, fingers that close.
        lifting: With the item, in the first stretch of the lift.
        carrying: With the item after its last contact.
    """

    approaching: Mode
    taking: Mode
    lifting: Mode
    carrying: Mode

    def holding(self, attached: AttachedItem) -> GraspModes:
        """Attach the item to the modes.

        Args:
            attached: The attached item.

        Returns:
            The modes; those after the grasp have the item attached.
        """
        lifting, carrying = (replace(mode, attached=attached) for mode in (self.lifting, self.carrying))
        return replace(self, lifting=lifting, carrying=carrying)


@dataclass(frozen=True, eq=False)
class GraspMethod(ABC):
    """Method by which a kind of tool grasps, holds and releases an item.

    Attributes:
        tool: The tool, of that kind.
        comes_in: The kind of segment in which the tool reaches an item.
        closes_at_rest: Whether the tool grasps by its own motion, while the arm rests.
        take_up: m of a lift in which the hold gives way until it bears the item's weight; 0 if it does not.
        take_up_speed: m/s, limit on that part if the weight bends the hold.
    """

    tool: Tool
    comes_in: ClassVar[SegmentKind]
    closes_at_rest: ClassVar[bool]

    @property
    def contact_limit(self) -> ContactLimit:
        """Speed limit for the tool's approach to an item."""
        return ContactLimit(self.comes_in, self.tool.contact_speed)

    @property
    def take_up(self) -> float:
        """Path in m over which an item's weight is taken up slowly; 0 if it is taken up at once."""
        return 0.0

    @property
    def take_up_speed(self) -> float:
        """Speed limit in m/s while the weight is taken up; infinite without such a path."""
        return np.inf

    @abstractmethod
    def may_hold(self, item: Item) -> bool:
        """Whether the tool may be able to hold an item in some way.

        Args:
            item: The item.

        Returns:
            True if it may, regardless of the item's pose.
        """

    @abstractmethod
    def sample(
        self, target: GraspTarget, rng: np.random.Generator, search: Search, most: float
    ) -> CandidateSet:
        """Sample grasp candidates for an item with a known pose.

        Args:
            target: The item to be grasped.
            rng: Source of the random places.
            search: How many places and turns are tried.
            most: Largest share of what the tool bears that the item at rest may take up.

        Returns:
            Candidates, and why others were dropped.
        """

    @abstractmethod
    def grasps_in(
        self, target: GraspTarget, envelope: Envelope, tool_state: ToolState, T_item_tip: Array, most: float
    ) -> CandidateSet:
        """Make grasp candidates of poses in an envelope of an item.

        Args:
            target: The item to be grasped.
            envelope: One of its envelopes, or a part of one.
            tool_state: State of the tool.
            T_item_tip: (N, 4, 4) poses of the tool in the envelope, up to rounding.
            most: Largest share of what the tool bears that the item at rest may take up.

        Returns:
            Candidates in the envelope, and why others were dropped.
        """

    @abstractmethod
    def envelopes(self, item: Item, depth: float) -> tuple[Envelope, ...]:
        """Return the envelopes in which the tool can grasp an item.

        Args:
            item: The item.
            depth: m, from the front of the hand or lance to the tip.

        Returns:
            The envelopes, in the item's frame; () if there is none.
        """

    def orientations(self, target: GraspTarget) -> Array | None:
        """Return in which orientations any search samples grasps of an item, wherever on it.

        Args:
            target: The item to be grasped.

        Returns:
            (K, 3, 3) axes of the tool frame in the item's; None if they are more than can be listed.
        """
        return None

    @abstractmethod
    def bears(self, item: Item, face: str, T_item_tip: Array, noise: PoseNoise = EXACT) -> HoldLimits:
        """Return what the tool bears for a grasp of an item.

        Args:
            item: The item.
            face: The name of the face under the cup, or of the pinched faces.
            T_item_tip: (4, 4) pose of the tool at the grasp.
            noise: Bounds of the error of the pose in which the item is grasped.

        Returns:
            The limits.
        """

    @abstractmethod
    def holding_state(self, face: str, tool_state: ToolState, item: Item) -> ToolState:
        """Return the state of the tool while it holds an item.

        Args:
            face: The name of the face under the cup, or of the pinched faces.
            tool_state: State of the tool that the item is grasped with.
            item: The item.

        Returns:
            The state.
        """

    @abstractmethod
    def contact_speed(self, contacts: PickContacts, grasp: Grasp) -> float | None:
        """Return the highest speed at which the tool may meet the target without tipping it over.

        Args:
            contacts: The scene, the target in it, and its support.
            grasp: Grasp of the target.

        Returns:
            m/s, at most the tool's contact speed; None if it tips the target at any useful speed.
        """

    def overtravel(self, face: str, T_item_tip: Array, noise: PoseNoise) -> Array:
        """Return how far the tool travels beyond the surface that it meets.

        Args:
            face: Face of the item's shape that it meets.
            T_item_tip: (N, 4, 4) poses of the tool at grasps on it.
            noise: Bounds of the target's pose error.

        Returns:
            (N,) m along the tool's axis; 0 if the tool is not pressed on the item.
        """
        return np.zeros(len(T_item_tip))

    @abstractmethod
    def at_target(self, contacts: PickContacts, face: str, tool_state: ToolState) -> tuple[Mode, ...]:
        """Return the modes in which the tool without the arm must be free at the target.

        Args:
            contacts: Contacts of the pick.
            face: The name of the face under the cup, or of the pinched faces.
            tool_state: State of the tool that the target is grasped with.

        Returns:
            The modes; the tool must have clearance in each.
        """

    @abstractmethod
    def modes(self, contacts: PickContacts, grasp: Grasp, tool_excess: float) -> GraspModes:
        """Return the modes of the segments of a grasp.

        Args:
            contacts: Contacts of the pick.
            grasp: Grasp of the target.
            tool_excess: m by which the model of the touching part is larger than the part.

        Returns:
            The modes, without the item (see ``GraspModes.holding``).
        """

    @abstractmethod
    def rests(self, devices: Mapping[str, Device], release_time: float) -> GraspTimes:
        """Return how long the arm rests when the tool grasps and when it releases an item.

        Args:
            devices: Devices of the cell, by name.
            release_time: s that an item takes to come off the tool.

        Returns:
            The rests.

        Raises:
            InputError: If the cell lacks the device that closes the tool.
        """

    def carrying(self, contacts: PickContacts, face: str, tool_state: ToolState) -> Mode:
        """Return the mode in which the tool without the arm must be free while it holds the target.

        Args:
            contacts: Contacts of the pick.
            face: The name of the face under the cup, or of the pinched faces.
            tool_state: State of the tool that the target is grasped with.

        Returns:
            The mode, without contacts.
        """
        state = self.holding_state(face, tool_state, contacts.target.item)
        return Mode(state, contacts=contacts.while_carrying())

    def hold(self, item: Item, face: str, T_tip_item: Array, noise: PoseNoise = EXACT) -> Hold:
        """Describe an item that the tool holds.

        Args:
            item: The held item.
            face: The name of the face under the cup, or of the pinched faces.
            T_tip_item: (4, 4) pose of the item in the tool frame.
            noise: Bounds of the error of the pose in which the item is grasped.

        Returns:
            The item with its largest mass and inertia, and what the tool bears.
        """
        return Hold.of(item, T_tip_item, self.bears(item, face, inverse(T_tip_item), noise))
