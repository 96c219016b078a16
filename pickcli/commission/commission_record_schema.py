"""Schema of the record of a trial of a commission: the fields that readers of many trials need."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pickcli.trial.record_schema import Count, Figure, RecordPart, Text, valid_record


class _Step(RecordPart):
    action: Text
    t_start: Figure
    t_end: Figure
    is_success: bool
    reason: Text


class _Item(RecordPart):
    id: Text
    outcome: Text


class _Off(RecordPart):
    distance: Figure
    turn: Figure


class _People(RecordPart):
    number: Count
    brake_requests: Count
    touched: Count
    walked_in: Count
    braked_s: Figure


class _MadeFrom(RecordPart):
    commission: Text
    seed: int


class _Record(RecordPart):
    success: bool
    items_ordered: Count
    items_placed: Count
    delivered: bool
    duration_s: Figure
    handling_s: Figure
    collisions: Count
    limit_violations: Count
    stops: Count
    aborted: Text
    people: _People | None = None
    pallet_off: _Off | None
    steps: list[_Step]
    items: list[_Item]
    made_from: _MadeFrom


def refuse_bad_commission_record(record: Mapping[str, Any], where: str) -> None:
    """Refuse a record with missing or malformed fields.

    Args:
        record: JSON values by name, of the right format and version.
        where: Name of the file, for messages.

    Raises:
        InputError: The record has faults: each with its field.
    """
    valid_record(record, _Record, where)
