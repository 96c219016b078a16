"""Schema of the record of a trial of a stream: the fields that readers of many trials need."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field

from pickcli.errors import InputError
from pickcli.stream_trials.stream_result import ItemOutcome
from pickcli.trial.record_schema import Count, Figure, RecordPart, Text, valid_record

Positive = Annotated[float, Field(ge=0.0, le=1e9)]


class _Meeting(RecordPart):
    slip: Positive
    offset: Positive
    late: Figure


class _Item(RecordPart):
    item: Text
    outcome: Text
    reason: Text
    attempts: Count
    met: _Meeting | None
    cost_bound: Positive | None = None


class _Queries(RecordPart):
    planned_ms: list[Positive]
    refused_ms: list[Positive]


class _Statistics(RecordPart):
    queries: _Queries


class _MadeFrom(RecordPart):
    stream: Text
    seed: Annotated[int, Field(ge=0, lt=2**31)]


class _Record(RecordPart):
    presented: Count
    attempted: Count
    delivered: Count
    collisions: Count
    limit_violations: Count
    stops: Count
    speed_m_s: Figure
    duration_s: Positive
    delivered_per_minute: Positive
    slip_m_s: dict[str, Figure] | None
    offset_m: dict[str, Figure] | None
    rule: Text
    items: list[_Item]
    made_from: _MadeFrom
    statistics: _Statistics


def refuse_bad_stream_record(record: Mapping[str, Any], where: str) -> None:
    """Refuse a record with missing or malformed fields, or with counts that are not those of its items.

    Args:
        record: JSON values by name, of the right format and version.
        where: Name of the file, for messages.

    Raises:
        InputError: The record has faults: each with its field; or its counts are others.
    """
    valid = valid_record(record, _Record, where)
    counted = {
        "presented": len(valid.items),
        "attempted": sum(item.attempts > 0 for item in valid.items),
        "delivered": sum(item.outcome == ItemOutcome.DELIVERED for item in valid.items),
    }
    for key, n in counted.items():
        if (stated := getattr(valid, key)) != n:
            fault = f"{key} is {stated}, but items has {n}"
            raise InputError(f"{where}: no sound record of a trial, {fault}; play it again")
