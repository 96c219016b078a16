"""Columns that roadmap and database files share: reasons for gaps, and the pod validity of rows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pickcli.cell.pod_tolerance import PodPoses, PodValidity
from pickcli.errors import Reason
from pickcli.storage.table_format import TEXT, AnyArray, Columns, Table
from pickcli.storage.table_reader import StoredFile

VALIDITY = ("pod_poses", "why_nominal")  # fields of a table, both TEXT


def validity_columns(validities: Sequence[PodValidity]) -> Columns:
    """Lay out the pod validity of each row as columns of a table.

    Args:
        validities: Pod validity of each row.

    Returns:
        The columns by name.
    """
    return {name: [getattr(validity, name) for validity in validities] for name in VALIDITY}


def validities_of(file: StoredFile, table: str) -> tuple[PodValidity, ...]:
    """Read the pod validity of each row of a table.

    Args:
        file: The open file.
        table: Name of the table.

    Returns:
        Pod validity of each row.

    Raises:
        ValueError: A row has an unknown value for the poses of the pod.
    """
    found, reasons = (file.texts(table, name) for name in VALIDITY)
    return tuple(PodValidity(PodPoses(pod_poses), why) for pod_poses, why in zip(found, reasons, strict=True))


def row_validity(row: Any) -> PodValidity:
    """Read the pod validity of one row of a table.

    Args:
        row: Record of the table.

    Returns:
        The pod validity.

    Raises:
        ValueError: The row has an unknown value for the poses of the pod.
    """
    pod_poses, why_nominal = (bytes(row[name]).decode() for name in VALIDITY)
    return PodValidity(PodPoses(pod_poses), why_nominal)


def reason_table(*names: str) -> Table:
    """Describe a table of gaps of a build: names per row, and the three parts of a Reason.

    Args:
        *names: Columns of names.

    Returns:
        The table.
    """
    return Table(dict.fromkeys((*names, "what", "where", "detail"), TEXT))


def reason_columns(names: Sequence[str], rows: Sequence[tuple[Sequence[str], Reason]]) -> Columns:
    """Lay out the gaps of a build as the columns of a table of reasons.

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
