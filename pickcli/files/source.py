"""Values of a file with the line and column of each, and all mistakes in them."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

from pickcli.errors import InputError

MAX_REPORTED = 20  # number of mistakes in one message

Key: TypeAlias = tuple[str | int, ...]  # path of a value: names in mappings, indices in lists


@dataclass(frozen=True)
class Problem:
    """One mistake in a file.

    Attributes:
        line: Counted from 1.
        column: Counted from 1.
        text: The problem and advice.
        path: The file, if it is another one than the file being read; else None.
    """

    line: int
    column: int
    text: str
    path: Path | None = None


@dataclass
class Source:
    """A file's values with their positions.

    Attributes:
        path: The file.
        data: Its values: mappings, lists, texts, numbers, switches and None.
        key_positions: Line and column, from 1, of the key of each entry of a mapping.
        value_positions: Line and column, from 1, of each value.
        origins: File, line and column of each value that was taken from another file.
        problems: Mistakes so far.
        n_unreported: Number of further mistakes that are not reported one by one.
    """

    path: Path
    data: Any = None
    key_positions: dict[Key, tuple[int, int]] = field(default_factory=dict)
    value_positions: dict[Key, tuple[int, int]] = field(default_factory=dict)
    origins: dict[Key, tuple[Path, int, int]] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    n_unreported: int = 0  # further mistakes, not reported one by one

    @property
    def is_full(self) -> bool:
        """Whether no more mistakes will be reported, so that suggestions need not be computed."""
        return len(self.problems) > MAX_REPORTED

    def add(self, key: Key, text: str) -> None:
        """Report a mistake.

        Args:
            key: Key of the value; if it is not in the file, the position of its nearest parent is used.
            text: The problem and advice.
        """
        path, line, column = self.place(key)
        self.problems.append(Problem(line, column, f"{name_of(key)}: {text}" if key else text, path))

    def stated(self, key: Key) -> Key:
        """Map a key of this view to the key in the file.

        Args:
            key: Key of the value.

        Returns:
            The same key; views of a part of the file override this.
        """
        return key

    def place(self, key: Key) -> tuple[Path | None, int, int]:
        """Find the position of a value or of its nearest parent in the file.

        Args:
            key: Key of the value.

        Returns:
            The file, None for this one, and line and column from 1.
        """
        while (
            key
            and key not in self.key_positions
            and key not in self.value_positions
            and key not in self.origins
        ):
            key = key[:-1]
        here = self.key_positions.get(key) or self.value_positions.get(key) or (1, 1)
        return self.origins.get(key) or (None, *here)

    def check(self) -> None:
        """Raise an error if there are mistakes.

        Raises:
            InputError: With all mistakes so far, in the order of the file.
        """
        if self.problems:
            ordered = sorted(set(self.problems), key=lambda p: (str(p.path or ""), p.line, p.column, p.text))
            lines = [f"{p.path or self.path}:{p.line}:{p.column}: {p.text}" for p in ordered[:MAX_REPORTED]]
            more = len(ordered) + self.n_unreported - len(lines)
            raise InputError("\n".join(lines + [f"{self.path}: and {more} more"] * (more > 0)))


def name_of(key: Key) -> str:
    """Format a key for messages: ``("rows", 0, "lip_top")`` as ``rows[0].lip_top``.

    Args:
        key: Key of a value.

    Returns:
        The text.
    """
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in key)
    return text.removeprefix(".")
