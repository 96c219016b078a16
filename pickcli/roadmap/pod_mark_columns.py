"""How it lies in a file for which pods a row was proven."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pickcli.cell.pod_tolerance import PodMark, PodStand
from pickcli.storage.table_format import Columns
from pickcli.storage.table_reader import StoredFile

MARK = ("stand", "why_nominal")  # fields of a table, both TEXT


def mark_columns(marks: Sequence[PodMark]) -> Columns:
    """The columns of these marks."""
    return {name: [getattr(mark, name) for mark in marks] for name in MARK}


def marks_of(file: StoredFile, table: str) -> tuple[PodMark, ...]:
    """The mark of each row of a table. Raises ValueError for an unknown stand."""
    stands, reasons = (file.texts(table, name) for name in MARK)
    return tuple(PodMark(PodStand(stand), why) for stand, why in zip(stands, reasons, strict=True))


def row_mark(row: Any) -> PodMark:
    """The same for one row of its table."""
    stand, why_nominal = (bytes(row[name]).decode() for name in MARK)
    return PodMark(PodStand(stand), why_nominal)
