"""Result of a trial of a commission: what every step did, and what became of items, pallet and truck."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from typing import Any

from pickcli.pallet_trials.pallet_result import SetDownDeviation
from pickcli.planning.pick_problem import StatedPlace

DELIVERED_OFF, DELIVERED_TURNED = 0.06, 0.035  # m and rad: what entry and drive may each be off, together


class ActionError(Exception):
    """Why an action of a commission failed: within its trial, whose tree decides what follows.

    Args:
        reason: Why.
        figures: Plain values by name, of what was done nevertheless.
    """

    def __init__(self, reason: str, figures: Mapping[str, Any] | None = None) -> None:
        super().__init__(reason)
        self.figures = dict(figures or {})


class CommissionedOutcome(StrEnum):
    """What became of an item."""

    PLACED = "placed"  # it stands in its place on the pallet at the end
    LEFT = "left"  # it stands on the load
    LOST = "lost"  # it is neither in its place nor on the load


@dataclass(frozen=True)
class CommissionStep:
    """One action of the tree that was carried out.

    Attributes:
        action: The action, with its arguments.
        target: Id of the item that it was for; "" for none.
        t_start: s of the trial.
        t_end: s of the trial.
        is_success: Whether it succeeded.
        reason: Why it failed, or what went wrong on the way; "" if nothing did.
        figures: Plain values by name, of its kind of action.
    """

    action: str
    target: str
    t_start: float
    t_end: float
    is_success: bool
    reason: str
    figures: Mapping[str, Any] = field(default_factory=dict)

    @property
    def told(self) -> str:
        """Why the step failed, and for how long the truck waited for people, if it did."""
        waited = self.figures.get("braked_s", 0.0)
        return "; ".join(filter(None, [self.reason, f"braked {waited:.1f} s for people" if waited else ""]))


@dataclass(frozen=True)
class CommissionedItem:
    """What became of an item.

    Attributes:
        id: Its id.
        outcome: What became of it.
        place: Where it was to stand, in the frame of the pallet.
        attempts: Number of executed motions.
        set_down: How far it was off its place after it was set down; None if nothing moved, or back only.
        at_end: The same after all drives; None if it is on the load, or was taken away by hand.
    """

    id: str
    outcome: CommissionedOutcome
    place: StatedPlace
    attempts: int
    set_down: SetDownDeviation | None
    at_end: SetDownDeviation | None

    @property
    def is_placed(self) -> bool:
        """Whether it stands in its place at the end."""
        return self.outcome is CommissionedOutcome.PLACED

    @property
    def told(self) -> str:
        """Name of the item and what became of it, with where it was last."""
        where = ""
        if self.outcome is CommissionedOutcome.LOST:
            last = self.at_end or self.set_down
            where = ", taken away by hand" if last is None else f", {last}"
        return f"{self.id}, {self.outcome}{where}"


@dataclass(frozen=True)
class FloorDeviation:
    """How far something on the floor is from where it should be.

    Attributes:
        distance: m.
        turn: rad, not negative.
    """

    distance: float
    turn: float


@dataclass(frozen=True)
class WatchedPeople:
    """What drives that were watched tell of people.

    Attributes:
        number: How many people came into the booth while the truck drove, or stood in it.
        braked_s: s for which the truck was braked or held for them.
        brake_requests: Number of brake requests.
        touched: How many the moving truck touched; these are collisions.
        walked_in: How many touched the moving truck by their own motion.
    """

    number: int
    braked_s: float
    brake_requests: int
    touched: int
    walked_in: int


@dataclass(frozen=True)
class CommissionResult:
    """Result of a trial.

    Attributes:
        steps: What was done, in order.
        items: All items of the commission, in its order.
        delivered: The pallet against where it was to be set down; None if it was not.
        truck: The truck at the end against where it was to be.
        n_collisions: Contacts of arm, truck and forks that were not planned.
        n_limit_violations: Violated joint limits.
        n_stops: Protective stops of the arm.
        aborted: Why the commission was ended early; "" if it was not.
        duration: s.
        handling: s of it in which the arm looked and moved.
        people: What drives tell of people; None if they were not watched.
    """

    steps: tuple[CommissionStep, ...]
    items: tuple[CommissionedItem, ...]
    delivered: FloorDeviation | None
    truck: FloorDeviation
    n_collisions: int
    n_limit_violations: int
    n_stops: int
    aborted: str
    duration: float
    handling: float
    people: WatchedPeople | None = None

    @property
    def n_placed(self) -> int:
        """Number of items that stand in their places at the end."""
        return sum(each.is_placed for each in self.items)

    @property
    def is_clean(self) -> bool:
        """Whether nothing collided and no limit was broken."""
        return self.n_collisions == self.n_limit_violations == 0

    @property
    def is_delivered(self) -> bool:
        """Whether the pallet stands where it was to be set down."""
        off = self.delivered
        return off is not None and off.distance <= DELIVERED_OFF and off.turn <= DELIVERED_TURNED

    @property
    def is_success(self) -> bool:
        """Whether the whole chain succeeded: all items on the pallet, delivered, and the truck out of it."""
        is_whole = self.n_placed == len(self.items) and self.is_delivered
        return is_whole and self.is_clean and not self.aborted

    def record(self) -> dict[str, Any]:
        """Return the record of the trial as JSON values.

        Returns:
            Figures, steps and items.
        """
        return {
            "success": self.is_success,
            "items_ordered": len(self.items),
            "items_placed": self.n_placed,
            "delivered": self.is_delivered,
            "duration_s": self.duration,
            "handling_s": self.handling,
            "collisions": self.n_collisions,
            "limit_violations": self.n_limit_violations,
            "stops": self.n_stops,
            "aborted": self.aborted,
            "people": None if self.people is None else asdict(self.people),
            "pallet_off": None if self.delivered is None else asdict(self.delivered),
            "truck_off": asdict(self.truck),
            "steps": [{**asdict(each), "figures": dict(each.figures)} for each in self.steps],
            "items": [{**asdict(each), "outcome": str(each.outcome)} for each in self.items],
        }
