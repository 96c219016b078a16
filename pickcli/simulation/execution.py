"""Record of the execution of a plan in the simulated world, as values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from pickcli.simulation.plan_record import PlanRecord

if TYPE_CHECKING:  # they need pybullet
    from pickcli.simulation.contacts import Collision
    from pickcli.simulation.grip import Release


@dataclass(frozen=True)
class Fall:
    """An item that left the cup, and how far it fell.

    Attributes:
        item: Id of the item.
        height: m that its lowest point fell until the execution ended.
        is_wanted: Whether the valve released it.
    """

    item: str
    height: float
    is_wanted: bool


@dataclass(frozen=True, eq=False, kw_only=True)
class Execution(PlanRecord):
    """What only the simulated world knows of a plan beside its record. Times are simulated seconds.

    Attributes:
        collisions: Contacts that no plan allows.
        releases: Items that left the cup.
        falls: How far these fell.
        held: Id of the item in the cup at the end, or None.
        max_load: Largest share of what the cup bears while something was held, from the lift on.
    """

    collisions: tuple[Collision, ...]
    releases: tuple[Release, ...]
    falls: tuple[Fall, ...]
    held: str | None
    max_load: float

    @property
    def counts(self) -> tuple[tuple[int, str], ...]:
        """How often what must not happen did, and what."""
        return ((len(self.collisions), "collisions"), *super().counts)
