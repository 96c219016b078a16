"""The columns of a table that say for which poses of the pod each row was proven."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pickcli.cell.pod_tolerance import PodPoses, PodValidity
from pickcli.storage.table_format import Columns
from pickcli.storage.table_reader import StoredFile

MARK = ("pod_poses", "why_nominal")  # fields of a table, both TEXT


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
        ValueError: A row names no poses of the pod that are known.
    """
    found, reasons = (file.texts(table, name) for name in MARK)
    return tuple(PodValidity(PodPoses(pod_poses), why) for pod_poses, why in zip(found, reasons, strict=True))


def row_mark(row: Any) -> PodValidity:
    """Read the validity of one row of a table.

    Args:
        row: Record of the table.

    Returns:
        For which pods the row holds.

    Raises:
        ValueError: The row names no poses of the pod that are known.
    """
    pod_poses, why_nominal = (bytes(row[name]).decode() for name in MARK)
    return PodValidity(PodPoses(pod_poses), why_nominal)
