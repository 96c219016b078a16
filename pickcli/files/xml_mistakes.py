"""Collects all mistakes of an XML file, and reports them together in the order of the file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from pickcli.errors import InputError

MAX_REPORTED = 20  # number of mistakes in one message

T = TypeVar("T")


@dataclass(eq=False)
class XmlMistakes:
    """Mistakes of an XML file.

    Attributes:
        path: The file.
        found: The mistakes with their positions, in the order in which they were found.
    """

    path: Path
    found: list[str] = field(default_factory=list)

    def note(self, error: InputError) -> None:
        """Add a mistake.

        Args:
            error: As created by ``Element.error``.
        """
        self.found.append(str(error))

    def tried(self, read: Callable[[], T], otherwise: T) -> T:
        """Call a reader; after a mistake continue with a placeholder.

        Args:
            read: Function that reads, or raises InputError, which is added.
            otherwise: The placeholder.

        Returns:
            The result, or ``otherwise``.
        """
        try:
            return read()
        except InputError as error:
            self.note(error)
            return otherwise

    def check(self) -> None:
        """Raise an error if there are mistakes.

        Raises:
            InputError: With all mistakes so far, in the order of the file.
        """
        if self.found:
            lines = sorted(dict.fromkeys(self.found), key=self._line)
            more = len(lines) - MAX_REPORTED
            reported = lines[:MAX_REPORTED] + [f"{self.path}: and {more} more"] * (more > 0)
            raise InputError("\n".join(reported))

    def _line(self, text: str) -> int:
        return int(text.removeprefix(f"{self.path}:").partition(":")[0])
