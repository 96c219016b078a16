"""The table at the end of a trial, for wide and narrow terminals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pickcli.cell.station import TOTE

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.table import Table

    from pickcli.trial.trial_summary import Row

WIDE = 120  # columns from which on reasons have their own column


def print_rows(console: Console, rows: Sequence[Row]) -> None:
    """Print one row per target; on a narrow terminal, the reasons follow as a list below.

    If stdout is not a terminal, every reason is printed on one line, however long, for use with grep.

    Args:
        console: The console.
        rows: The targets.
    """
    is_wide = console.width >= WIDE
    console.print(_table(rows, is_wide))
    if not is_wide:
        for row in rows:
            if row.reason:
                line = f"{row.bin} {row.item}: {row.reason}"
                console.print(line, markup=False, highlight=False, soft_wrap=not console.is_terminal)


def _table(rows: Sequence[Row], has_reasons: bool) -> Table:
    from rich.table import Table
    from rich.text import Text

    # Without a frame the longest name fits into 80 columns.
    table = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False)
    are_moves = any(row.into != TOTE for row in rows)
    for title in ("from", "item", "to", "outcome") if are_moves else ("bin", "item", "outcome"):
        table.add_column(title, overflow="fold")
    for title in ("points", "planning\nms", "motion\ns"):
        table.add_column(title, justify="right")
    if has_reasons:
        table.add_column("reason", overflow="fold")
    for row in rows:
        into = [row.into] if are_moves else []
        cells: list[RenderableType] = [row.bin, row.item, *into, row.outcome, str(row.points), _planning(row)]
        cells.append(f"{row.motion_s:.1f}")
        table.add_row(*cells, *([Text(row.reason)] if has_reasons else []))
    return table


def _planning(row: Row) -> str:
    return "-" if row.planning_ms is None else f"{row.planning_ms:.0f}"
