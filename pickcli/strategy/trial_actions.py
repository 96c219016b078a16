"""What a strategy sees of a trial, and what it can do in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from pickcli.strategy.node_types import ActionKind


@dataclass(frozen=True)
class OpenTarget:
    """A target for which something can still be tried.

    Attributes:
        index: Its line in the order.
        item: Name of the item.
        bin: Its place at the start.
        points: Points for its delivery.
        n_attempts: Number of attempts so far.
        n_items: Number of items in its bin, as last perceived.
        has_no_plan: Whether planning failed in the present scene.
        rates: Expected points per second of each action that can be tried.
    """

    index: int
    item: str
    bin: str
    points: int
    n_attempts: int = 0
    n_items: int = 1
    has_no_plan: bool = False
    rates: Mapping[ActionKind, float] = field(default_factory=dict)

    def __str__(self) -> str:
        return f"{self.bin} {self.item}"


class TrialActions(Protocol):
    """A trial, as its strategy sees it. Actions return after they have been carried out."""

    @property
    def now(self) -> float:
        """Time on the trial's clock, s."""

    @property
    def time_left(self) -> float:
        """Time until the end of the trial, s."""

    @property
    def has_time_to_plan(self) -> bool:
        """Whether one more planning call would end in time."""

    def open_targets(self) -> Sequence[OpenTarget]:
        """Return the targets for which something can still be tried, in the order of their lines."""

    def look(self) -> bool:
        """Look at the scene again.

        Returns:
            False if there is no time for it.
        """

    def pick(self, index: int) -> bool:
        """Make one attempt at a target.

        Args:
            index: Its line in the order.

        Returns:
            Whether it is delivered.
        """

    def clear(self, index: int) -> bool:
        """Move one item aside that blocks a target.

        Args:
            index: Its line in the order.

        Returns:
            Whether the target may be tried again.
        """

    def give_up(self, index: int) -> None:
        """Close a target.

        Args:
            index: Its line in the order.
        """
