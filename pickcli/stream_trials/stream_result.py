"""Result of a trial of a stream: what became of each item that the belt brought, and how well it was met."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

import numpy as np


class ItemOutcome(StrEnum):
    """What became of an item of a stream."""

    DELIVERED = "delivered"
    LOST = "lost"  # attempted, or knocked off in an attempt at another, and not where it was to be brought
    NOT_ATTEMPTED = "not attempted"


@dataclass(frozen=True)
class MeetingRecord:
    """How an item was met, measured in simulation.

    Attributes:
        t_contact: s of the stream at which the contact was planned to be made.
        late: s from the planned contact until the tool held the item.
        slip: m/s, largest speed of the tool along the belt relative to the item while it was to take it, but
            for the step in which it took hold of it.
        offset: m between the tool and its planned place on the item, across the tool's axis, when it was to
            lift.
    """

    t_contact: float
    late: float
    slip: float
    offset: float


@dataclass(frozen=True)
class StreamItemResult:
    """One item of a stream.

    Attributes:
        item: Its id.
        outcome: What became of it.
        attempts: Number of motions to take it.
        reason: Why it was not attempted, or what stopped the last attempt; empty if nothing did.
        t_end: s of the stream at which its last attempt ended; None without one.
        met: How it was met last; None if the tool never held it.
        arm: Name of the arm that attempted it last; empty without an attempt, or with a single arm.
        clearance: m, the least distance that the certificate of the last attempt's plan states; None without
            an attempt.
        cost_bound: The proven bound on the cost of the transit of the last attempt; None where ARA* did not
            plan it.
    """

    item: str
    outcome: ItemOutcome
    attempts: int
    reason: str
    t_end: float | None = None
    met: MeetingRecord | None = None
    arm: str = ""
    clearance: float | None = None
    cost_bound: float | None = None


@dataclass(frozen=True)
class StreamTrialResult:
    """A trial of a stream.

    Attributes:
        speed: m/s of the belt.
        items: Every item, in the order of the stream.
        n_collisions: Number of unplanned contacts.
        n_limit_violations: Number of violated joint limits.
        n_stops: Number of protective stops, after each of which the arm was brought home by hand.
        t_end: s of the stream at which the last motion ended.
        planning_ms: Wall-clock ms of each query with a plan: filters of grasps, planning and verification.
        refusing_ms: The same of each query without one.
        together: s in which more than one arm moved.
    """

    speed: float
    items: tuple[StreamItemResult, ...]
    n_collisions: int
    n_limit_violations: int
    n_stops: int
    t_end: float
    planning_ms: tuple[float, ...]
    refusing_ms: tuple[float, ...]
    together: float = 0.0

    @property
    def is_clean(self) -> bool:
        """Whether nothing collided and no limit was broken."""
        return self.n_collisions == self.n_limit_violations == 0

    def count(self, outcome: ItemOutcome) -> int:
        """Count the items with an outcome.

        Args:
            outcome: The outcome.

        Returns:
            Their number.
        """
        return sum(each.outcome is outcome for each in self.items)

    @property
    def n_attempted(self) -> int:
        """Number of items for which the arm moved."""
        return sum(each.attempts > 0 for each in self.items)

    @property
    def cost_bound(self) -> dict[str, float] | None:
        """The proven bounds on the cost of transits by ARA*, as ``percentiles``; None without any."""
        return percentiles([each.cost_bound for each in self.items if each.cost_bound is not None])

    def _attempted_by_arm(self) -> dict[str, int]:
        """Count the items that each arm attempted last, by its name; empty with a single arm."""
        return dict(sorted(Counter(each.arm for each in self.items if each.arm).items()))

    def record(self) -> dict[str, Any]:
        """Return the record of the trial as JSON values.

        Returns:
            Numbers, figures and every item; wall-clock times stand under ``statistics``.
        """
        met = [each.met for each in self.items if each.met is not None]
        delivered, by_arm = self.count(ItemOutcome.DELIVERED), self._attempted_by_arm()
        return {
            "presented": len(self.items),
            "attempted": self.n_attempted,
            "delivered": delivered,
            "collisions": self.n_collisions,
            "limit_violations": self.n_limit_violations,
            "stops": self.n_stops,
            "speed_m_s": self.speed,
            "duration_s": self.t_end,
            "delivered_per_minute": 60.0 * delivered / self.t_end if self.t_end > 0.0 else 0.0,
            "slip_m_s": percentiles([each.slip for each in met]),
            "offset_m": percentiles([each.offset for each in met]),
            "late_s": percentiles([each.late for each in met]),
            **({"attempted_by": by_arm, "together_s": self.together} if by_arm else {}),
            "items": [{**asdict(each), "outcome": str(each.outcome)} for each in self.items],
            "statistics": {
                "planning_ms": percentiles(self.planning_ms),
                "refusing_ms": percentiles(self.refusing_ms),
                "queries": {"planned_ms": list(self.planning_ms), "refused_ms": list(self.refusing_ms)},
            },
        }


def percentiles(values: Sequence[float]) -> dict[str, float] | None:
    """Describe the distribution of values by what is typical, rare and worst.

    Args:
        values: Any number of values.

    Returns:
        ``median``, ``p95``, ``p99`` and ``worst``; None without values.
    """
    if not values:
        return None
    median, p95, p99 = np.percentile(values, [50.0, 95.0, 99.0]).tolist()
    return {"median": median, "p95": p95, "p99": p99, "worst": float(max(values))}
