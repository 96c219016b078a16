"""What holds items in the simulated world, by a cup or between pads: what every kind has in common."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from pickcli.geometry import Array
from pickcli.simulation.engine import ContactPoint


@dataclass(frozen=True, eq=False)
class Release:
    """An item that left cup or pads.

    Attributes:
        item: Id of the item.
        t: s, simulated.
        is_wanted: Whether the tool let go of it; else it broke away.
        T_world_item: (4, 4) pose when it left.
        load: The last one measured, as the kind of tool states it.
    """

    item: str
    t: float
    is_wanted: bool
    T_world_item: Array
    load: Any


class Grip(Protocol):
    """What holds items.

    Attributes:
        held: Name of the item that is held, or None.
        attached: Name of the item that the engine lets through the links that hold, or None: what holds it
            is worked out beside the engine.
        ratio: The last load, while it is to hold, as a share of what the tool bears.
        releases: Items that left, in their order.
        contact_points: What was met in the last step beside the engine's own contacts.
    """

    held: str | None
    ratio: float
    releases: list[Release]
    contact_points: list[ContactPoint]

    @property
    def attached(self) -> str | None:
        """Name of the item that the engine lets through the links that hold, or None."""

    @property
    def is_holding(self) -> bool:
        """What the tool's sensor says: whether it holds anything."""

    def before_step(self, T_world_tip: Array) -> None:
        """Update all forces between tool and item; before the engine steps.

        Args:
            T_world_tip: (4, 4) tool frame.
        """

    def after_step(self, t: float) -> None:
        """Take hold, slip and let go; after the engine stepped.

        Args:
            t: Simulated time, s.
        """

    def is_apart(self, item: str) -> bool:
        """Whether the links that held an item may collide with it again.

        Args:
            item: Name of an item that is attached no more.
        """


class NoGrip:
    """A flange on which nothing is mounted: it meets nothing by itself, and holds nothing."""

    def __init__(self) -> None:
        self.held: str | None = None
        self.ratio = 0.0
        self.releases: list[Release] = []
        self.contact_points: list[ContactPoint] = []

    @property
    def attached(self) -> str | None:
        """Name of the item that is attached: never one."""
        return None

    @property
    def is_holding(self) -> bool:
        """Whether a sensor says that something is held: no, there is none."""
        return False

    def before_step(self, T_world_tip: Array) -> None:
        """Do nothing before a step: a flange exerts no force.

        Args:
            T_world_tip: (4, 4) of the flange.
        """

    def after_step(self, t: float) -> None:
        """Do nothing after a step: a flange takes no hold.

        Args:
            t: Simulated time, s.
        """

    def is_apart(self, item: str) -> bool:
        """Nothing was ever held.

        Args:
            item: Name of an item.

        Returns:
            True.
        """
        return True
