"""The schema of plan files: JSON text to Plan, every problem named with its field.

Each type of a plan is declared once, as a dataclass of this package. The names of its fields in a file, their
allowed values, and how they are written and read follow from the declaration; only constraints that a type
cannot express are stated here. Only a trajectory has another structure in a file: points, not columns.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from enum import StrEnum
from functools import cache
from itertools import islice
from reprlib import Repr
from types import MappingProxyType, UnionType
from typing import Annotated, Any, Literal, get_args, get_type_hints

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError, conlist, create_model

from pickcli.cell.cell import ArmState
from pickcli.cell.tool import ToolState
from pickcli.errors import InputError, StaleError
from pickcli.files.json_reader import parse_json
from pickcli.files.schema import causes, explain
from pickcli.files.source import name_of
from pickcli.geometry import Array, is_pose
from pickcli.motion.event import Anchor, AnchorKind, Event
from pickcli.motion.plan import (
    MAX_DURATION,
    MAX_NUMBER,
    Certificate,
    Grasp,
    LineTracking,
    Plan,
    RecoveryLevel,
)
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.name_suggestion import shortened

FORMAT = "apc plan"
VERSION = 3
MAX_POINTS = 100_000
MAX_JOINTS = 32
LEFT_OUT = ("pushing", "envelope")  # fields that are not written if they are empty
TIME_TOLERANCE = 1e-9  # s, between the end of a segment and the start of the next
MAX_PROBLEMS = 20  # named in one message

_SHORT = Repr()  # abbreviates values of any size
_SHORT.maxstring = _SHORT.maxother = 60

Name = Annotated[str, Field(min_length=1, max_length=200)]
Hash = Annotated[str, Field(max_length=128)]
Number = Annotated[float, Field(allow_inf_nan=False, ge=-MAX_NUMBER, le=MAX_NUMBER)]
Numbers = Annotated[list[Number], Field(max_length=MAX_JOINTS)]
Time = Annotated[float, Field(allow_inf_nan=False, ge=0.0, le=MAX_DURATION)]


class _Model(BaseModel):
    """Strict model: no unknown keys, no strings for numbers."""

    model_config = ConfigDict(extra="forbid", strict=True)


class _Point(_Model):
    positions: Numbers
    velocities: Numbers
    accelerations: Numbers
    time_from_start: Time


class _Trajectory(_Model):
    joint_names: Annotated[list[Name], Field(min_length=1, max_length=MAX_JOINTS)]
    points: Annotated[list[_Point], Field(min_length=2, max_length=MAX_POINTS)]


@cache
def _field_types(kind: type) -> dict[str, Any]:
    """Return the types of a dataclass's fields by name, which is also the key in a file."""
    hints = get_type_hints(kind)
    return {field.name: hints[field.name] for field in fields(kind)}


def _derived(kind: type, also: Mapping[str, Any] = MappingProxyType({}), **special: Any) -> Any:
    """Derive the schema of a dataclass in a file: fields by type or by ``special``, and additional keys."""
    keys = {name: special.get(name, _FILE_TYPES.get(of, of)) for name, of in _field_types(kind).items()}
    return create_model(f"_{kind.__name__}", __base__=_Model, **also, **keys)


def plain(value: Any, kind: Any = None) -> Any:
    """Convert a value of a plan to JSON values.

    Args:
        value: The value.
        kind: The declared type of its field; None for a dataclass.

    Returns:
        JSON values; for a dataclass an object, its keys in the order of its fields.
    """
    if value is None:
        return None
    if isinstance(value, ToolState | StrEnum):
        return str(value)
    if is_dataclass(value):
        own: type = type(value)
        values = {name: (getattr(value, name), of) for name, of in _field_types(own).items()}
        return {name: plain(*each) for name, each in values.items() if name not in LEFT_OUT or each[0]}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple):
        return list(value)
    # Numpy scalars, and integers in a field for floats, are written in the declared type.
    return float(value) if kind in (float, float | None) else int(value) if kind is int else value


def _built(kind: Any, value: Any) -> Any:
    """Build the value of a type from its validated model."""
    if isinstance(kind, UnionType):
        return None if value is None else _built(get_args(kind)[0], value)
    if kind is Trajectory:
        return _trajectory(value)
    if kind is ToolState:
        return ToolState(value)
    if is_dataclass(kind):
        assert isinstance(kind, type)
        return kind(**{name: _built(of, getattr(value, name)) for name, of in _field_types(kind).items()})
    if kind == Array:
        return np.array(value)
    return tuple(_built(get_args(kind)[0], v) for v in value) if isinstance(value, list) else value


def _trajectory(model: _Trajectory) -> Trajectory:
    """Build the trajectory from a file's points."""
    names = ("time_from_start", "positions", "velocities", "accelerations")
    columns = (np.array([getattr(point, name) for point in model.points]) for name in names)
    return Trajectory(tuple(model.joint_names), *columns)


_FILE_TYPES: dict[Any, Any] = {
    str: Name,
    str | None: Name | None,
    float: Number,
    float | None: Number | None,
    ToolState: Name,
    SegmentKind: Annotated[SegmentKind, Field(strict=False)],
    AnchorKind: Annotated[AnchorKind, Field(strict=False)],
}
_Row = Annotated[list[Number], Field(min_length=4, max_length=4)]
_Pose = Annotated[list[_Row], Field(min_length=4, max_length=4)]

_Names = Annotated[list[Name], Field(max_length=1000)]
_Segment = _derived(
    Segment, t_start=Time, t_end=Time, touching=_Names, pushing=Annotated[_Names, Field(default=[])]
)
_Anchor = _derived(Anchor, segment=Annotated[int, Field(ge=0, lt=1000)])
_Event = _derived(Event, anchor=_Anchor, lead=Time)
_Grasp = _derived(
    Grasp, T_item_tip=_Pose, score=Annotated[Number, Field(ge=0.0)],
    envelope=Annotated[str, Field(max_length=200, default="")],
)  # fmt: skip
_Certificate = _derived(
    Certificate, also={"seal": Hash}, motion_hash=Hash, scene_hash=Hash, cell_fingerprint=Hash,
    n_states=Annotated[int, Field(ge=0, lt=2**53)], checks=Annotated[list[Name], Field(max_length=100)],
)  # fmt: skip


_ArmState = _derived(ArmState, q=Numbers)
_Speed = Annotated[float, Field(allow_inf_nan=False, ge=0.0, le=5.0)]
_Deviation = Annotated[float, Field(allow_inf_nan=False, ge=0.0, le=1.0, default=0.0)]
_LineTracking = _derived(
    LineTracking,
    speed=_Speed,
    speed_error=Annotated[_Speed, Field(default=0.0)],
    deviation=_Deviation,
    t_stream=Annotated[float, Field(allow_inf_nan=False, ge=0.0, le=1e6, default=0.0)],
)
_Plan = _derived(
    Plan,
    also={"format": Literal["apc plan"], "version": Literal[3]},
    query=Annotated[str, Field(max_length=1000)],
    cell_fingerprint=Hash,
    scene_hash=Hash,
    seed=Annotated[int, Field(ge=0, lt=2**63)],
    segments=conlist(_Segment, min_length=1, max_length=1000),
    trajectory=_Trajectory,
    events=conlist(_Event, max_length=1000),
    grasp=Annotated[
        _Grasp | None,
        Field(
            description="the grasp, or null for a move",
            json_schema_extra={"advice": "add them, or set it to null for a move"},
        ),
    ],
    speed_scale=Annotated[float, Field(gt=0.0, le=1.0)],
    certificate=Annotated[
        _Certificate | None,
        Field(
            description="the verifier's certificate, or null for a plan that was not verified",
            json_schema_extra={"advice": "set it to null, then run apc verify --write"},
        ),
    ],
    statistics=Annotated[dict[Name, Annotated[float, Field(allow_inf_nan=False)]], Field(max_length=1000)],
    recovery=Annotated[RecoveryLevel | None, Field(strict=False, default=None)],
    arm=Annotated[str, Field(max_length=200, default="")],
    others=Annotated[conlist(_ArmState, max_length=MAX_JOINTS), Field(default=[])],
    tracking=Annotated[_LineTracking | None, Field(default=None)],
    upright=Annotated[
        Annotated[float, Field(allow_inf_nan=False, gt=0.0, le=0.5 * math.pi)] | None, Field(default=None)
    ],
)


def parse_plan(text: str, where: str) -> tuple[Plan, str]:
    """Read the text of a plan's file.

    Args:
        text: JSON.
        where: Name of the file, for messages.

    Returns:
        The plan, and the seal of its certificate ("" without one).

    Raises:
        InputError: With the place where the JSON breaks, or with all problems (field, expected, got).
        StaleError: The plan is of another version of the format.
    """
    data = parse_json(text, where)
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise InputError(f'{where}: format: expected "{FORMAT}"; this is not a plan file')
    version = data.get("version")
    if type(version) is not int:
        raise InputError(f"{where}: version: expected {VERSION}, got {_SHORT.repr(version)}; plan it again")
    if version != VERSION:
        raise StaleError(
            f"{where}: version: expected {VERSION}, got {version}, of another apc; plan it again"
        )
    try:
        model = _Plan.model_validate(data)
    except ValidationError as error:
        found = causes(error)
        raise _refusal(where, len(found), map(_problem, found)) from None
    problems = list(_problems(model))
    if problems:
        raise _refusal(where, len(problems), problems)
    return _built(Plan, model), model.certificate.seal if model.certificate is not None else ""


def _problem(error: Any) -> str:
    """Format one pydantic error as ``field: expected, got; what to do``."""
    key = tuple(part if isinstance(part, int) else shortened(part) for part in error["loc"])
    fault = explain(_Plan, error["loc"], error)
    return f"{name_of(key)}: {fault}" if key else fault


def _refusal(where: str, count: int, problems: Iterable[str]) -> InputError:
    """Build one error for ``count`` problems, of which the first are listed."""
    more = f"\n  and {count - MAX_PROBLEMS} more" if count > MAX_PROBLEMS else ""
    return InputError("\n  ".join([f"{where}: not a valid plan:", *islice(problems, MAX_PROBLEMS)]) + more)


def _problems(model: Any) -> Iterator[str]:
    """Yield violated constraints between fields: shapes, times, contiguous segments, indices in range."""
    yield from _trajectory_problems(model.trajectory)
    yield from _segment_problems(model)
    for i, event in enumerate(model.events):
        if event.anchor.segment >= len(model.segments):
            yield (
                f"events[{i}].anchor.segment: expected an index below {len(model.segments)}, "
                f"got {event.anchor.segment}"
            )
    if model.grasp is not None and not is_pose(np.array(model.grasp.T_item_tip)):
        yield "grasp.T_item_tip: expected a rigid transform (4 x 4)"


def _trajectory_problems(trajectory: _Trajectory) -> Iterator[str]:
    n = len(trajectory.joint_names)
    if len(set(trajectory.joint_names)) != n:
        yield "trajectory.joint_names: a name stands twice"
    points = trajectory.points
    for i, point in enumerate(points):
        for name in ("positions", "velocities", "accelerations"):
            if len(getattr(point, name)) != n:
                yield f"trajectory.points[{i}].{name}: expected {n} numbers, got {len(getattr(point, name))}"
        if i > 0 and not point.time_from_start > points[i - 1].time_from_start:
            yield (
                f"trajectory.points[{i}].time_from_start: expected over {points[i - 1].time_from_start} "
                f"(times must increase strictly), got {point.time_from_start}"
            )
    if points[0].time_from_start != 0.0:
        yield f"trajectory.points[0].time_from_start: expected 0, got {points[0].time_from_start}"
    for i in (0, len(points) - 1):
        if any(v != 0.0 for v in points[i].velocities):
            yield f"trajectory.points[{i}].velocities: expected 0: a motion starts and ends at rest"


def _segment_problems(model: Any) -> Iterator[str]:
    t = 0.0
    for i, segment in enumerate(model.segments):
        if abs(segment.t_start - t) > TIME_TOLERANCE:
            yield f"segments[{i}].t_start: expected {t} (where the one before ends), got {segment.t_start}"
        if not segment.t_end > segment.t_start:
            yield f"segments[{i}].t_end: expected over {segment.t_start}, got {segment.t_end}"
        t = segment.t_end
    if abs(t - (end := model.trajectory.points[-1].time_from_start)) > TIME_TOLERANCE:
        yield f"segments[{len(model.segments) - 1}].t_end: expected {end} (the trajectory's end), got {t}"
