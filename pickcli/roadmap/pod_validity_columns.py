"""The columns of a table that say for which poses of the pod each row was proven."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pickcli.cell.pod_tolerance import PodStand, PodValidity
from pickcli.storage.table_format import Columns
from pickcli.storage.table_reader import StoredFile

MARK = ("stand", "why_nominal")  # fields of a table, both TEXT


def mark_columns(marks: Sequence[PodValidity]) -> Columns:
    """Lay out one validity per row as columns of a table.

    Args:
        marks: For which pods each row holds.

    Returns:
        The columns by name.
    """
    return {name: [getattr(mark, name) for mark in marks] for name in MARK}


def marks_of(file: StoredFile, table: str) -> tuple[PodValidity, ...]:
    """Read the validity of each row of a table.

    Args:
        file: The open file.
        table: Name of the table.

    Returns:
        For which pods each row holds.

    Raises:
        ValueError: A stand of the pod is unknown.
    """
    stands, reasons = (file.texts(table, name) for name in MARK)
    return tuple(PodValidity(PodStand(stand), why) for stand, why in zip(stands, reasons, strict=True))


def row_mark(row: Any) -> PodValidity:
    """Read the validity of one row of a table.

    Args:
        row: Record of the table.

    Returns:
        For which pods the row holds.

    Raises:
        ValueError: The stand of the pod is unknown.
    """
    stand, why_nominal = (bytes(row[name]).decode() for name in MARK)
    return PodValidity(PodStand(stand), why_nominal)
