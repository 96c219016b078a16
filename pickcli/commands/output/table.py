"""Tables on stdout that fit the terminal."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from shutil import get_terminal_size
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

FILE_WIDTH = 100  # columns of output that does not go to a terminal, unless COLUMNS is set


def known_width() -> int | None:
    """Return the width of stdout, if known.

    Returns:
        Columns of the terminal, else the value of COLUMNS; None if neither is known.
    """
    is_known = sys.stdout.isatty() or os.environ.get("COLUMNS", "").isdecimal()
    return get_terminal_size().columns if is_known else None


def stdout_width() -> int:
    """Return the width of stdout, or a default.

    Returns:
        Columns of stdout; those of a file if unknown.
    """
    return known_width() or FILE_WIDTH


def stdout_console() -> Console:
    """Make a console with the width of stdout.

    Returns:
        The console.
    """
    from rich.console import Console

    return Console(width=stdout_width())


def table_lines(head: Sequence[str], rows: Sequence[Sequence[str]], width: int | None = None) -> list[str]:
    """Format the head and a line per row: the first column left-aligned, the others right-aligned.

    Args:
        head: The titles.
        rows: The cells, with one entry per title in each row.
        width: Columns of a line; None for those of the terminal, or unlimited if stdout is not one. If there
            is too little room, titles are wrapped, and then cells.

    Returns:
        The lines.
    """
    if width is None:
        width = stdout_width() if sys.stdout.isatty() else sys.maxsize
    if (lines := _lines(head, rows, width)) is not None:
        return lines
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False)
    for i, title in enumerate(head):
        table.add_column(title, justify="left" if i == 0 else "right", overflow="fold")
    for row in rows:
        table.add_row(*row)
    console = Console(width=width, no_color=True, highlight=False, markup=False)
    with console.capture() as captured:
        console.print(table)
    return [line.rstrip() for line in captured.get().splitlines()]


def _lines(head: Sequence[str], rows: Sequence[Sequence[str]], width: int) -> list[str] | None:
    """Format every row on its own line; return None if that is too wide."""
    widths = [max(len(row[i]) for row in (head, *rows)) for i in range(len(head))]
    lines = ["  ".join(_padded(row, widths)).rstrip() for row in (head, *rows)]
    return lines if max(map(len, lines)) <= width else None


def _padded(row: Sequence[str], widths: Sequence[int]) -> list[str]:
    first, *others = zip(row, widths, strict=True)
    return [first[0].ljust(first[1]), *(text.rjust(width) for text, width in others)]
