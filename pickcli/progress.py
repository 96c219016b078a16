"""Progress of long work: its value, and the interface of its observers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True)
class Progress:
    """Progress of a long piece of work.

    Attributes:
        done: Work done so far, in any unit: tasks, bins, seconds of a motion.
        total: Total work, in the same unit.
        what: Current step, or the last finished one; "" if there is nothing to report.
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
        """Text to be shown besides the numbers."""
        return self.what

    def seconds_left(self, elapsed: float) -> float | None:
        """Estimate the remaining time.

        Args:
            elapsed: s since the start.

        Returns:
            s, extrapolated from the elapsed time; None before anything is done.
        """
        return None if self.share is None else elapsed * (1.0 / self.share - 1.0)


class ProgressObserver(Protocol):
    """Observer of progress, which does not influence the work."""

    def __call__(self, progress: Progress, /) -> None:
        """Receive the current progress."""


def nobody(progress: Progress, /) -> None:
    """Ignore a report of progress.

    Args:
        progress: Ignored.
    """
