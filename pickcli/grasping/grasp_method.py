"""What picks ask of a kind of tool: which grasps there are, how the tool comes to an item, what it bears.

Suction and the pinch of two fingers differ in the same few ways wherever a pick is planned. Each is one class
with these methods; `method_choice` is the one place that asks which kind of tool a cell has.
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
from pickcli.grasping.grasp_target import CandidateSet, GraspTarget
from pickcli.grasping.holding import Hold, HoldLimits
from pickcli.grasping.search import Search
from pickcli.motion.plan import Grasp
from pickcli.motion.segment import SegmentKind


@dataclass(frozen=True)
class GraspTimes:
    """How long the arm rests where the tool takes an item and where it lets it go.

    Attributes:
        taking: s.
        releasing: s.
    """

    taking: float
    releasing: float


@dataclass(frozen=True)
class ContactLimit:
    """How fast a tool may come to an item.

    Attributes:
        kind: The kind of segment in which it comes that near: a cup in the contact, fingers, which pass the
            item on both sides, in the approach.
        speed: m/s.
    """

    kind: SegmentKind
    speed: float


@dataclass(frozen=True)
class GraspModes:
    """What each stage of taking an item by one grasp must be free for.

    Attributes:
        approaching: Of the empty tool on its way to the item, or away from it.
        taking: Of the empty tool at the item: a cup that is pressed on, fingers that close.
        lifting: With the item, over the first stretch of the lift.
        carrying: With the item when it touches nothing any more.
        overtravel: m by which the tool goes on beyond the surface that it meets.
    """

    approaching: Mode
    taking: Mode
    lifting: Mode
    carrying: Mode
    overtravel: float = 0.0

    def holding(self, attached: AttachedItem) -> GraspModes:
        """The modes with the item.

        Args:
            attached: The item in the tool.

        Returns:
            The modes, of which those after the item was taken have it.
        """
        lifting, carrying = (replace(mode, attached=attached) for mode in (self.lifting, self.carrying))
        return replace(self, lifting=lifting, carrying=carrying)


@dataclass(frozen=True, eq=False)
class GraspMethod(ABC):
    """How a kind of tool takes an item, holds it and lets it go.

    Attributes:
        tool: The tool, of that kind.
        comes_in: The kind of segment in which the tool comes to an item.
        closes_at_rest: Whether the tool takes an item by a motion of its own, while the arm rests.
        take_up: m of a lift in which the hold gives way until it bears the item's weight; 0 if it does not.
        take_up_speed: m/s, the fastest in that stretch where the weight bends the hold.
    """

    tool: Tool
    comes_in: ClassVar[SegmentKind]
    closes_at_rest: ClassVar[bool]

    @property
    def contact_limit(self) -> ContactLimit:
        """How fast the tool may come to an item."""
        return ContactLimit(self.comes_in, self.tool.contact_speed)

    @property
    def take_up(self) -> float:
        """Path in m over which an item's weight is taken up slowly; 0 where it is taken up at once."""
        return 0.0

    @property
    def take_up_speed(self) -> float:
        """The fastest speed in m/s while the weight is taken up; infinite without such a path."""
        return np.inf

    @abstractmethod
    def may_hold(self, item: Item) -> bool:
        """Whether there is a way, known or not, in which the tool holds an item.

        Args:
            item: The item.

        Returns:
            True if there may be one; without knowing where it lies.
        """

    @abstractmethod
    def sample(
        self, target: GraspTarget, rng: np.random.Generator, search: Search, most: float
    ) -> CandidateSet:
        """Candidates for an item whose pose is known.

        Args:
            target: What is to be grasped.
            rng: Source of the random places.
            search: How many places and turns are tried.
            most: Largest share of what the tool bears that the item at rest may take up.

        Returns:
            Candidates, best first, and why others were dropped.
        """

    @abstractmethod
    def bears(self, item: Item, face: str, T_item_tip: Array) -> HoldLimits:
        """What the tool bears where it holds an item.

        Args:
            item: The item.
            face: The name of the face under the cup, or of what is pinched.
            T_item_tip: (4, 4) where the tool holds it.

        Returns:
            The limits.
        """

    @abstractmethod
    def holding_state(self, grasp: Grasp, item: Item) -> ToolState:
        """The state of the tool while it holds an item.

        Args:
            grasp: How it holds the item.
            item: The item.

        Returns:
            The state.
        """

    @abstractmethod
    def contact_speed(self, contacts: PickContacts, grasp: Grasp) -> float | None:
        """The fastest that the tool may meet the target, so that it does not tip it over.

        Args:
            contacts: The scene, the target in it, and what carries that.
            grasp: Where the tool takes the target.

        Returns:
            m/s, at most the tool's contact speed; None where it tips the target at any useful speed.
        """

    @abstractmethod
    def at_target(self, contacts: PickContacts, grasp: Grasp) -> tuple[Mode, ...]:
        """What the tool by itself must be free for at the target.

        Args:
            contacts: Of the pick.
            grasp: Where the tool takes the target; only its face and its state count.

        Returns:
            The modes, in each of which it must have room.
        """

    @abstractmethod
    def modes(self, contacts: PickContacts, grasp: Grasp, tool_excess: float) -> GraspModes:
        """What each stage of a grasp must be free for.

        Args:
            contacts: Of the pick.
            grasp: Where the tool takes the target.
            tool_excess: m by which the model of what meets the item is larger than it is.

        Returns:
            The modes, without the item (see ``GraspModes.holding``).
        """

    @abstractmethod
    def rests(self, devices: Mapping[str, Device], release_time: float) -> GraspTimes:
        """How long the arm rests where the tool takes an item and where it lets it go.

        Args:
            devices: Devices of the cell, by name.
            release_time: s that an item takes to come off what has let go of it.

        Returns:
            The rests.

        Raises:
            InputError: If the cell lacks the device that closes the tool.
        """

    def carrying(self, contacts: PickContacts, grasp: Grasp) -> Mode:
        """What the tool by itself must be free for while it holds the target, which touches nothing.

        Args:
            contacts: Of the pick.
            grasp: How it holds the target.

        Returns:
            The mode.
        """
        state = self.holding_state(grasp, contacts.target.item)
        return Mode(state, contacts=contacts.while_carrying())

    def hold(self, item: Item, face: str, T_tip_item: Array) -> Hold:
        """An item that the tool holds.

        Args:
            item: What is held.
            face: The name of the face under the cup, or of what is pinched.
            T_tip_item: (4, 4) the item in the tool frame.

        Returns:
            The item with its mass and inertia as large as they may be, and what the tool bears.
        """
        return Hold.of(item, T_tip_item, self.bears(item, face, inverse(T_tip_item)))
