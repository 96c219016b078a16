"""What a build could not have, kept in its file: names and a reason per row."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pickcli.errors import Reason
from pickcli.storage.table_format import TEXT, AnyArray, Columns, Table


def reason_table(*names: str) -> Table:
    """Describe a table of what a build could not have: names per row, and the three parts of a Reason.

    Args:
        *names: Columns of names.

    Returns:
        The table.
    """
    return Table(dict.fromkeys((*names, "what", "where", "detail"), TEXT))


def reason_columns(names: Sequence[str], rows: Sequence[tuple[Sequence[str], Reason]]) -> Columns:
    """Lay out what a build could not have as the columns of a table of reasons.

    Args:
        names: Columns of names.
        rows: The names and the reason of each row.

    Returns:
        The columns by name.
    """
    columns: dict[str, Sequence[str]] = {name: [key[i] for key, _ in rows] for i, name in enumerate(names)}
    return columns | {
        part: [getattr(reason, part) for _, reason in rows] for part in ("what", "where", "detail")
    }


def reason_row(names: Sequence[str], row: Any) -> tuple[tuple[str, ...], Reason]:
    """Read one row of a table of reasons.

    Args:
        names: Columns of names.
        row: Record of the table.

    Returns:
        Its names and its reason.
    """
    return tuple(_text(row[name]) for name in names), Reason(
        *(_text(row[p]) for p in ("what", "where", "detail"))
    )


def reason_rows(names: Sequence[str], table: AnyArray) -> tuple[tuple[tuple[str, ...], Reason], ...]:
    """Read all rows of a table of reasons.

    Args:
        names: Columns of names.
        table: (K,) records.

    Returns:
        Names and reason of each row.
    """
    return tuple(reason_row(names, row) for row in table)


def _text(value: Any) -> str:
    return bytes(value).decode()
