"""Schema of a trial's record: the fields that readers need, with each fault reported by field.

Records have further fields, not all of them in every cell; fields that are not in the schema are not checked.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pickcli.cell.schemas.pose_schema import Name
from pickcli.errors import InputError
from pickcli.files.schema import causes, explain
from pickcli.files.source import name_of
from pickcli.name_suggestion import shortened

MAX_REPORTED = 8  # number of faults reported in one message
MOST_SAME = 100_000  # number of reasons that differ only in figures

Text = Annotated[str, Field(max_length=20_000)]
Count = Annotated[int, Field(ge=0, lt=2**31)]
Points = Annotated[int, Field(gt=-(2**31), lt=2**31)]
Figure = Annotated[float, Field(ge=-1e9, le=1e9)]


Part = TypeVar("Part", bound="RecordPart")


class RecordPart(BaseModel):
    """A part of a record; fields that it does not name are not checked."""

    model_config = ConfigDict(strict=True, allow_inf_nan=False)


class _Target(RecordPart):
    bin: Text
    item: Text
    outcome: Text
    reason: Text
    points: Points


class _Reason(RecordPart):
    what: Text
    where: Text
    detail: Text
    in_the_way: Text
    count: Annotated[int, Field(ge=1, le=MOST_SAME)]


class _Collision(RecordPart):
    a: Text
    b: Text
    t_start: Figure
    depth: Figure
    force: Figure


class _Drop(RecordPart):
    item: Text
    height: Figure
    is_release: bool


class _Moved(RecordPart):
    item: Text
    kind: Text
    moved: Figure


class _Event(RecordPart):
    device: Text
    action: Text
    t: Figure
    distance: Figure
    reading: bool | None


class _Execution(RecordPart):
    stopped: Text
    collisions: list[_Collision]
    drops: list[_Drop]
    disturbed: list[_Moved]
    events: list[_Event]


class _Step(RecordPart):
    execution: _Execution | None


class _Plan(RecordPart):
    query: Text


class _Attempt(RecordPart):
    bin: Text
    item: Text
    out_of: Text
    into: Text
    is_aside: bool
    topples: bool = False
    number: Count
    outcome: Text
    reason: Text
    reasons: list[_Reason] = []
    rejected: list[list[_Reason]] = []
    plan: _Plan | None = None
    execution: _Execution | None
    recovery: list[_Step]
    parking: _Execution | None = None


class _Tick(RecordPart):
    t: Figure
    node: Text
    target: Text
    status: Text


class _Seen(RecordPart):
    place: Text
    item: Text
    refusal: Text
    bound_mm: Figure | None
    bound_deg: Figure | None
    bound_surface_mm: Figure | None = None
    truly_off_mm: Figure | None
    truly_off_deg: Figure | None
    truly_off_surface_mm: Figure | None = None


class _Look(RecordPart):
    number: Count
    cameras: dict[Name, Annotated[list[Text], Field(min_length=2, max_length=2)]]
    items: list[_Seen]
    motions: Count = 0
    motion_s: Figure = 0.0


class _ScoreLine(RecordPart):
    points: Points
    subject: Text
    reason: Text


class _Shift(RecordPart):
    x_mm: Figure
    y_mm: Figure
    yaw_deg: Figure


class _ToteTouches(RecordPart):
    reason: Text
    duration_s: Figure
    bound: _Shift | None = None
    truly_off: _Shift | None = None


class _MadeFrom(RecordPart):
    order: Text
    seed: int
    cell: Text
    scene_hash: Text


class _Record(RecordPart):
    score: Points
    max_score: Count
    items: list[_Target]
    items_in_tote: Count
    misjudged: Count
    collisions: Count
    limit_violations: Count
    drops: Count
    disturbed: Count
    simulated_s: Figure
    clock_s: Figure
    aborted: Text
    pod_shift: _Shift
    tote_shift: _Shift | None = None
    tote_touches: _ToteTouches | None = None
    attempts: list[_Attempt]
    ticks: list[_Tick] = []
    looks: list[_Look] = []
    score_lines: list[_ScoreLine]
    made_from: _MadeFrom


def valid_record(record: Mapping[str, Any], model: type[Part], where: str) -> Part:
    """Check the fields of a record against a model.

    Args:
        record: JSON values by name, of the right format and version.
        model: The fields that are checked.
        where: Name of the file, for messages.

    Returns:
        The fields.

    Raises:
        InputError: The record has faults: each with its field.
    """
    try:
        return model.model_validate(record)
    except ValidationError as error:
        found = causes(error)
        faults = [f"{_place(detail['loc'])}: {explain(model, detail['loc'], detail)}" for detail in found]
        more = [f"and {len(found) - MAX_REPORTED} more"] if len(found) > MAX_REPORTED else []
        lines = [f"{where}: no sound record of a trial; play it again:", *faults[:MAX_REPORTED], *more]
        raise InputError("\n  ".join(lines)) from None


def refuse_bad_record(record: Mapping[str, Any], where: str) -> None:
    """Refuse a trial record with missing or malformed fields that its readers need.

    Args:
        record: JSON values by name, of the right format and version.
        where: Name of the file, for messages.

    Raises:
        InputError: The record has faults: each with its field; or its points do not add up.
    """
    valid = valid_record(record, _Record, where)
    if fault := _false_sum(valid):
        raise InputError(f"{where}: no sound record of a trial, {fault}; play it again")


def _false_sum(record: _Record) -> str:
    """Compare all points with the lines of the score, those of the targets first; "" if they are equal."""
    total = sum(line.points for line in record.score_lines)
    if record.score != total:
        return f"score is {record.score}, but score_lines add up to {total}"
    if len(record.score_lines) < len(record.items):
        return f"score_lines has {len(record.score_lines)} lines for {len(record.items)} items"
    for k, (target, line) in enumerate(zip(record.items, record.score_lines, strict=False)):
        if target.points != line.points:
            return f"items[{k}].points is {target.points}, but score_lines[{k}].points {line.points}"
    return ""


def _place(loc: tuple[int | str, ...]) -> str:
    key = tuple(part if isinstance(part, int) else shortened(part) for part in loc)
    return name_of(key) if key else "record"
