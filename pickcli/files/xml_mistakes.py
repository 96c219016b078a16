"""All mistakes of an XML file told at once, in the order of the file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from pickcli.errors import InputError

MOST_TOLD = 20  # mistakes in one message

T = TypeVar("T")


@dataclass(eq=False)
class XmlMistakes:
    """What is wrong with an XML file.

    Attributes:
        path: The file.
        found: The mistakes with their places, in the order in which they were found.
    """

    path: Path
    found: list[str] = field(default_factory=list)

    def note(self, error: InputError) -> None:
        """Keep a mistake.

        Args:
            error: As ``Element.error`` makes it.
        """
        self.found.append(str(error))

    def tried(self, read: Callable[[], T], otherwise: T) -> T:
        """Read something, so that reading can go on where it is wrong.

        Args:
            read: Reads it, or raises InputError, which is noted.
            otherwise: What is taken in its stead.

        Returns:
            What was read, or ``otherwise``.
        """
        try:
            return read()
        except InputError as error:
            self.note(error)
            return otherwise

    def check(self) -> None:
        """Refuse the file if any mistake was noted.

        Raises:
            InputError: With all mistakes noted so far, in the order of the file.
        """
        if self.found:
            lines = sorted(dict.fromkeys(self.found), key=self._line)
            more = len(lines) - MOST_TOLD
            told = lines[:MOST_TOLD] + [f"{self.path}: and {more} more"] * (more > 0)
            raise InputError("\n".join(told))

    def _line(self, text: str) -> int:
        return int(text.removeprefix(f"{self.path}:").partition(":")[0])
