"""Which of the items on a conveyor is taken next: the one after which most of the others still can be.

Every item counts the same, and has a deadline: the time at which its pick has to begin, before it leaves the
window. Picks take about the same time, so that after the next one as many as possible are begun in time if
they are taken in the order of their deadlines and those that are past are left out (Moore, An n job, one
machine sequencing algorithm for minimizing the number of late jobs, Management Science 15 (1), 1968, for
equal durations).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class PlannedPick:
    """A pick of which there is a plan.

    Attributes:
        item: Id of the item.
        duration: s from the decision until the arm is free again.
        busy: s of these in which it is at work, not at rest until the item comes.
    """

    item: str
    duration: float
    busy: float


def next_pick(picks: Sequence[PlannedPick], deadlines: Mapping[str, float]) -> int:
    """Choose the pick that is carried out.

    Args:
        picks: At least one.
        deadlines: s from the decision until the pick of an item has to begin at the latest, by its id: of
            every item on the conveyor that may be taken, these among them.

    Returns:
        Index of the pick after which most of the others can be begun in time; of those the one that is over
        first.
    """
    lasts = sum(pick.busy for pick in picks) / len(picks)

    def worth(k: int) -> tuple[int, float]:
        others = (deadline for item, deadline in deadlines.items() if item != picks[k].item)
        return _begun_in_time(picks[k].duration, lasts, others), -picks[k].duration

    return max(range(len(picks)), key=worth)


def _begun_in_time(t: float, lasts: float, deadlines: Iterable[float]) -> int:
    """Count the picks that can be begun in time from a time t (s) on, one after the other.

    lasts: s of each of them
    deadlines: s
    """
    n = 0
    for deadline in sorted(deadlines):
        if t <= deadline:
            t, n = t + lasts, n + 1
    return n
