"""Protocol of grips in the simulated world, which hold items by a cup or between pads."""

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
        is_wanted: Whether the tool released it; otherwise it broke away.
        T_world_item: (4, 4) pose when it left.
        load: Last measured load, in the form of the kind of tool.
    """

    item: str
    t: float
    is_wanted: bool
    T_world_item: Array
    load: Any


class Grip(Protocol):
    """Simulated grip that holds items.

    Attributes:
        held: Name of the held item, or None.
        attached: Name of the item without collision physics with the contact links, or None: its hold is
            computed outside the engine.
        ratio: Last load during a hold, as a share of the tool's limits.
        releases: Items that left, in order.
        contact_points: Contacts of the last step in addition to the engine's.
    """

    held: str | None
    ratio: float
    releases: list[Release]
    contact_points: list[ContactPoint]

    @property
    def attached(self) -> str | None:
        """Name of the item without collision physics with the contact links, or None."""

    @property
    def is_holding(self) -> bool:
        """Reading of the tool's sensor: whether an item is held."""

    def before_step(self, T_world_tip: Array) -> None:
        """Update all forces between tool and item; call before the engine's step.

        Args:
            T_world_tip: (4, 4) tool frame.
        """

    def after_step(self, t: float) -> None:
        """Take hold, slip and release; call after the engine's step.

        Args:
            t: Simulated time, s.
        """

    def is_apart(self, item: str) -> bool:
        """Whether the links that held an item may collide with it again.

        Args:
            item: Name of an item that is no longer attached.

        Returns:
            True if they may.
        """


class NoGrip:
    """Grip of a flange without a tool: it holds nothing and exerts no forces."""

    def __init__(self) -> None:
        self.held: str | None = None
        self.ratio = 0.0
        self.releases: list[Release] = []
        self.contact_points: list[ContactPoint] = []

    @property
    def attached(self) -> str | None:
        """Name of the attached item: always None."""
        return None

    @property
    def is_holding(self) -> bool:
        """Reading of a sensor: always False, as there is none."""
        return False

    def before_step(self, T_world_tip: Array) -> None:
        """Do nothing before a step.

        Args:
            T_world_tip: (4, 4) of the flange.
        """

    def after_step(self, t: float) -> None:
        """Do nothing after a step.

        Args:
            t: Simulated time, s.
        """

    def is_apart(self, item: str) -> bool:
        """Whether the links that held an item may collide with it: always, as none was held.

        Args:
            item: Name of an item.

        Returns:
            True.
        """
        return True
