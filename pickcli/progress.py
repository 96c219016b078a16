"""How far a long piece of work is: one value, and one way in which everything tells it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True)
class Progress:
    """How far a long piece of work is.

    Attributes:
        done: What is done by now, in any unit: tasks, bins, seconds of a motion.
        total: What there is to be done, in the same unit.
        what: What happens now, or what was finished last; "" where there is nothing to say.
    """

    done: float
    total: float
    what: str = ""

    @property
    def share(self) -> float | None:
        """Share of the work that is done, in (0, 1]; None before anything is."""
        return self.done / self.total if 0 < self.done <= self.total else None

    @property
    def detail(self) -> str:
        """What there is to say beside the figures."""
        return self.what

    def seconds_left(self, elapsed: float) -> float | None:
        """Estimate the time that is left.

        Args:
            elapsed: s that the work has taken so far.

        Returns:
            s, as if the rest took its share of the time; None before anything is done.
        """
        return None if self.share is None else elapsed * (1.0 / self.share - 1.0)


class ProgressObserver(Protocol):
    """Observer of progress: it is told how far work is, and decides nothing about the work."""

    def __call__(self, progress: Progress, /) -> None:
        """Take note of how far the work is."""


def nobody(progress: Progress, /) -> None:
    """Take a report of progress and do nothing with it: nobody waits for it.

    Args:
        progress: Ignored.
    """
