"""Record of a plan's execution in the simulated world."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from pickcli.simulation.plan_record import PlanRecord

if TYPE_CHECKING:  # they need pybullet
    from pickcli.simulation.contacts import Collision
    from pickcli.simulation.grip import Release


@dataclass(frozen=True)
class Fall:
    """An item that left the tool, and the height of its fall.

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
    """Record of an execution with quantities known only in simulation. Times are simulated seconds.

    Attributes:
        collisions: Unplanned contacts.
        releases: Items that left the tool.
        falls: Falls of these items.
        held: Id of the item held at the end, or None.
        max_load: Largest load as a share of the tool's limits, from the lift on.
    """

    collisions: tuple[Collision, ...]
    releases: tuple[Release, ...]
    falls: tuple[Fall, ...]
    held: str | None
    max_load: float

    @property
    def counts(self) -> tuple[tuple[int, str], ...]:
        """Numbers and names of the kinds of events that must not happen."""
        return ((len(self.collisions), "collisions"), *super().counts)
