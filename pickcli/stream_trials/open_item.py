"""An item of a stream while it is open: where it truly rides, and what was tried with it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pickcli.scene.item_stream import RidingItem
from pickcli.stream_trials.stream_result import ItemOutcome, MeetingRecord, StreamItemResult

TRY_AGAIN = 0.5  # s after which an item without a plan is tried again


@dataclass
class OpenItem:
    """An item of the stream that is neither delivered nor lost yet: where it truly rides, and what was tried.

    Attributes:
        riding: Where it truly rides.
        attempts: Number of picks of it that were executed.
        reason: Why it is not taken, as far as that is known; "" if nothing is against it.
        t_next: s of the stream before which it is not asked for again.
        t_released: s of the stream until which an arm is at it, and nobody else meets it.
        t_end: s at which the last attempt at it was over; None before the first.
        met: How the tool met it; None if it did not.
        arm: The arm that tried it last.
        clearance: m, proven of the last plan for it.
        cost_bound: Proven bound on the cost of that plan's transit; None without one.
        was_known: Whether it was ever perceived.
        refusals: Why an arm had no plan when it was first asked, by arm.
        is_planned: Whether there was a plan when it was last asked for.
        is_refused: Whether there ever was none.
    """

    riding: RidingItem
    attempts: int = 0
    reason: str = ""
    t_next: float = 0.0
    t_released: float = 0.0
    t_end: float | None = None
    met: MeetingRecord | None = None
    arm: str = ""
    clearance: float | None = None
    cost_bound: float | None = None
    was_known: bool = False
    refusals: dict[str, str] = field(default_factory=dict)
    is_planned: bool = False
    is_refused: bool = False

    def refuse(self, arm: str, why: str) -> None:
        """Note why an arm has no plan; of several queries the first, as later ones are only told "too late".

        Args:
            arm: The arm.
            why: The reason.
        """
        self.refusals.setdefault(arm, why)
        if len(self.refusals) > 1:
            self.reason = "; ".join(f"arm {name}: {each}" for name, each in self.refusals.items())
        else:
            self.reason = self.refusals[arm]

    def note_plan(self) -> None:
        """Forget why there was no plan before: if the item passes all the same, others were taken instead."""
        self.is_planned, self.reason = True, ""
        self.refusals.clear()

    def note_refusal(self, t: float, t_other: float = np.inf) -> None:
        """Put the next query off, but not for what had a plan just before.

        Args:
            t: s of the stream, now.
            t_other: s of the stream at which an arm rests that was not asked.
        """
        self.t_next = t if self.is_planned else min(t + TRY_AGAIN, t_other)
        self.is_planned, self.is_refused = False, True

    def result(self, outcome: ItemOutcome) -> StreamItemResult:
        """Return what became of the item.

        Args:
            outcome: Whether it was delivered, lost or not attempted.

        Returns:
            The result, with the reason if it was not delivered.
        """
        missed = "the arm was busy with others" if self.was_known else "it was never seen well enough"
        return StreamItemResult(
            self.riding.id,
            outcome,
            self.attempts,
            self.reason or ("" if outcome is ItemOutcome.DELIVERED else missed),
            self.t_end,
            self.met,
            self.arm,
            self.clearance,
            self.cost_bound,
        )
