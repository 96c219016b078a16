"""Remembers which items no tool can take as they lie, and which were pushed over or off others in vain."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

from pickcli.cell.place import Place
from pickcli.cell.shapes import ShapeKind
from pickcli.errors import Reason
from pickcli.scene.scene import PlacedItem
from pickcli.trial.trial_result import Attempt, Outcome

MOST_PUSHES = 10  # against one item
MOST_JAMS = 3  # of those, that move it no farther than its pose may be off
STANDS = ("no face within reach", "tips the item")  # reasons of a pose in which no grasp is possible
OUT_OF_REACH = ("collision", "no room for the tool", "no inverse-kinematics solution")  # at the item
MOST_SHARE = 0.5  # of the reasons against an item, that must be of these kinds


@dataclass
class TopplingMemory:
    """What a trial knows about items that stand on edge.

    Attributes:
        can_push: Whether any tool of the cell pushes items over.
        standing: Ids of the items whose last attempt had no plan because of their pose.
        cramped: Ids of the items whose last attempt had no plan because of their pose, or of the walls around
            the way of the tool to them.
        in_vain: Ids of the items that cannot be toppled before something else has moved.
        blocking: By id of such an item, the ids of what it would meet as it turns over.
        n_pushed: Number of pushes against each item.
        n_jammed: Number of those that did not move it.
    """

    can_push: bool = True
    standing: set[str] = field(default_factory=set)
    cramped: set[str] = field(default_factory=set)
    in_vain: set[str] = field(default_factory=set)
    blocking: dict[str, tuple[str, ...]] = field(default_factory=dict)
    n_pushed: Counter[str] = field(default_factory=Counter)
    n_jammed: Counter[str] = field(default_factory=Counter)

    def note(self, attempt: Attempt) -> None:
        """Learn from an attempt.

        Args:
            attempt: The attempt, of any kind.
        """
        if attempt.execution is not None:
            self.in_vain.clear()  # something has moved
            self.blocking.clear()
            self.standing.discard(attempt.item)
            self.cramped.discard(attempt.item)
            if attempt.topples:
                self.n_pushed[attempt.item] += 1
                self.n_jammed[attempt.item] += attempt.outcome is Outcome.NOT_TOPPLED
                if attempt.execution.stopped:  # what jams would stop the next push, too
                    self.in_vain.add(attempt.item)
        elif attempt.topples:
            self.in_vain.add(attempt.item)
            self.blocking[attempt.item] = attempt.in_the_way
        elif attempt.outcome in (Outcome.NO_PLAN, Outcome.REJECTED):
            for names, at in ((self.standing, "contact"), (self.cramped, "")):
                n_of_pose = sum(_is_of_pose(reason, at) for reason in attempt.reasons)
                is_of_pose = n_of_pose > MOST_SHARE * len(attempt.reasons)
                (names.add if is_of_pose else names.discard)(attempt.item)

    def is_due(self, placed: PlacedItem, place: Place, can_be_held: bool = True) -> bool:
        """Whether an item should be pushed: it has no grasp as it lies, and it was not tried too often.

        Args:
            placed: The item as perceived.
            place: The place that it is in; in an open box or a bin it turns over and stays, but in a bin
                nothing is pushed off others, so neither what cannot be held nor what is no box.
            can_be_held: Whether any tool may hold it in some pose.

        Returns:
            True if it should.
        """
        is_bin = not place.access.is_from_above
        may_turn_over = can_be_held and placed.item.shape.kind is ShapeKind.BOX
        can_turn = self.can_push and (place.is_open_box or (is_bin and may_turn_over))
        has_no_grasp = self.cramped if is_bin else self.standing
        known = (placed.id in has_no_grasp or not can_be_held) and placed.id not in self.in_vain
        is_tried = self.n_pushed[placed.id] >= MOST_PUSHES or self.n_jammed[placed.id] >= MOST_JAMS
        return can_turn and known and not is_tried


def _is_of_pose(reason: Reason, at: str) -> bool:
    """Whether a grasp failed, at some stage, by the item's pose between walls and robot, not by others."""
    is_at_item = reason.what in OUT_OF_REACH and at in reason.where and not reason.in_the_way
    return reason.what in STANDS or is_at_item
