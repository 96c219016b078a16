"""The schema of plan files: JSON text to Plan, every problem named with its field."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice
from reprlib import Repr
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pickcli.cell.tool import ToolState
from pickcli.errors import InputError, shortened
from pickcli.files.json_reader import parse_json
from pickcli.files.schema import causes, explain
from pickcli.files.yaml_reader import name_of
from pickcli.geometry import is_pose
from pickcli.motion.event import Anchor, AnchorKind, Event
from pickcli.motion.plan import MAX_DURATION, MAX_NUMBER, Certificate, Grasp, Plan, RecoveryLevel
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory

FORMAT = "apc plan"
VERSION = 2
MAX_POINTS = 100_000
MAX_JOINTS = 32
TIME_TOLERANCE = 1e-9  # s, between the end of a segment and the start of the next
MAX_PROBLEMS = 20  # named in one message

_SHORT = Repr()  # of values of any size
_SHORT.maxstring = _SHORT.maxother = 60

Name = Annotated[str, Field(min_length=1, max_length=200)]
Hash = Annotated[str, Field(max_length=128)]
Number = Annotated[float, Field(allow_inf_nan=False, ge=-MAX_NUMBER, le=MAX_NUMBER)]
Numbers = Annotated[list[Number], Field(max_length=MAX_JOINTS)]
Time = Annotated[float, Field(allow_inf_nan=False, ge=0.0, le=MAX_DURATION)]


class _Model(BaseModel):
    """Strict: no unknown keys, no strings for numbers."""

    model_config = ConfigDict(extra="forbid", strict=True)


class _Point(_Model):
    positions: Numbers
    velocities: Numbers
    accelerations: Numbers
    time_from_start: Time


class _Trajectory(_Model):
    joint_names: Annotated[list[Name], Field(min_length=1, max_length=MAX_JOINTS)]
    points: Annotated[list[_Point], Field(min_length=2, max_length=MAX_POINTS)]


class _Segment(_Model):
    kind: Annotated[SegmentKind, Field(strict=False)]
    t_start: Time
    t_end: Time
    pivot: Name
    held: Name | None
    touching: Annotated[list[Name], Field(max_length=1000)]


class _Anchor(_Model):
    kind: Annotated[AnchorKind, Field(strict=False)]
    segment: Annotated[int, Field(ge=0, lt=1000)]
    offset: Number


class _Event(_Model):
    device: Name
    action: Name
    anchor: _Anchor
    lead: Time
    t_anchor: Number | None
    t_trigger: Number | None


class _Grasp(_Model):
    item: Name
    kind: Name
    face: Name
    pivot: Name
    T_item_tip: Annotated[
        list[Annotated[list[Number], Field(min_length=4, max_length=4)]], Field(min_length=4, max_length=4)
    ]
    score: Annotated[Number, Field(ge=0.0)]
    moment: Number
    pull: Number
    shear: Number
    twist: Number
    load_ratio: Number


class _Certificate(_Model):
    motion_hash: Hash
    scene_hash: Hash
    cell_fingerprint: Hash
    n_states: Annotated[int, Field(ge=0, lt=2**53)]
    max_step: Number
    min_clearance: Number
    max_velocity_ratio: Number
    max_acceleration_ratio: Number
    max_jerk_ratio: Number
    checks: Annotated[list[Name], Field(max_length=100)]
    seal: Hash


class _Plan(_Model):
    format: Literal["apc plan"]
    version: Literal[2]
    query: Annotated[str, Field(max_length=1000)]
    cell_fingerprint: Hash
    scene_hash: Hash
    seed: Annotated[int, Field(ge=0, lt=2**63)]
    speed_scale: Annotated[float, Field(gt=0.0, le=1.0)]
    recovery: Annotated[RecoveryLevel | None, Field(strict=False)] = None
    grasp: _Grasp | None = Field(
        description="the grasp, or null for a move",
        json_schema_extra={"advice": "add them, or set it to null for a move"},
    )
    segments: Annotated[list[_Segment], Field(min_length=1, max_length=1000)]
    events: Annotated[list[_Event], Field(max_length=1000)]
    trajectory: _Trajectory
    certificate: _Certificate | None = Field(
        description="the verifier's certificate, or null for a plan that was not verified",
        json_schema_extra={"advice": "set it to null, then run apc verify --write"},
    )
    statistics: Annotated[dict[Name, Annotated[float, Field(allow_inf_nan=False)]], Field(max_length=1000)]


def parse_plan(text: str, where: str) -> tuple[Plan, str]:
    """Read the text of a plan's file.

    Args:
        text: JSON.
        where: Name of the file, for messages.

    Returns:
        The plan, and the seal of its certificate ("" without one).

    Raises:
        InputError: With the place where the JSON breaks, or with all problems (field, expected, got).
    """
    data = parse_json(text, where)
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise InputError(f'{where}: format: expected "{FORMAT}"; this is not a plan file')
    if type(data.get("version")) is not int or data["version"] != VERSION:
        raise InputError(f"{where}: version: expected {VERSION}, got {data.get('version')!r}; plan it anew")
    try:
        model = _Plan.model_validate(data)
    except ValidationError as error:
        found = causes(error)
        raise _refusal(where, len(found), map(_problem, found)) from None
    problems = list(_problems(model))
    if problems:
        raise _refusal(where, len(problems), problems)
    return _build(model), model.certificate.seal if model.certificate is not None else ""


def _problem(error: Any) -> str:
    """One pydantic error as ``field: expected, got; what to do``."""
    key = tuple(part if isinstance(part, int) else shortened(part) for part in error["loc"])
    told = explain(_Plan, error["loc"], error)
    return f"{name_of(key)}: {told}" if key else told


def _refusal(where: str, count: int, problems: Iterable[str]) -> InputError:
    """One error for ``count`` problems, of which the first are told."""
    more = f"\n  and {count - MAX_PROBLEMS} more" if count > MAX_PROBLEMS else ""
    return InputError("\n  ".join([f"{where}: not a valid plan:", *islice(problems, MAX_PROBLEMS)]) + more)


def _problems(model: _Plan) -> Iterator[str]:
    """What types cannot say: shapes, order of times, contiguous segments, indices in range."""
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


def _segment_problems(model: _Plan) -> Iterator[str]:
    t = 0.0
    for i, segment in enumerate(model.segments):
        if abs(segment.t_start - t) > TIME_TOLERANCE:
            yield f"segments[{i}].t_start: expected {t} (where the one before ends), got {segment.t_start}"
        if not segment.t_end > segment.t_start:
            yield f"segments[{i}].t_end: expected over {segment.t_start}, got {segment.t_end}"
        t = segment.t_end
    if abs(t - (end := model.trajectory.points[-1].time_from_start)) > TIME_TOLERANCE:
        yield f"segments[{len(model.segments) - 1}].t_end: expected {end} (the trajectory's end), got {t}"


def _build(model: _Plan) -> Plan:
    points = model.trajectory.points
    return Plan(
        query=model.query,
        cell_fingerprint=model.cell_fingerprint,
        scene_hash=model.scene_hash,
        seed=model.seed,
        segments=tuple(_segment(s) for s in model.segments),
        trajectory=Trajectory(
            joint_names=tuple(model.trajectory.joint_names),
            times=np.array([p.time_from_start for p in points]),
            positions=np.array([p.positions for p in points]),
            velocities=np.array([p.velocities for p in points]),
            accelerations=np.array([p.accelerations for p in points]),
        ),
        events=tuple(_event(e) for e in model.events),
        grasp=None if model.grasp is None else _grasp(model.grasp),
        speed_scale=model.speed_scale,
        certificate=None if model.certificate is None else _certificate(model.certificate),
        statistics=dict(model.statistics),
        recovery=model.recovery,
    )


def _segment(model: _Segment) -> Segment:
    return Segment(
        model.kind, model.t_start, model.t_end, ToolState(model.pivot), model.held, tuple(model.touching)
    )


def _event(model: _Event) -> Event:
    return Event(**{**dict(model), "anchor": Anchor(**dict(model.anchor))})


def _grasp(model: _Grasp) -> Grasp:
    figures = {name: value for name, value in model if name != "pivot"}
    return Grasp(
        **{**figures, "tool_state": ToolState(model.pivot), "T_item_tip": np.array(model.T_item_tip)}
    )


def _certificate(model: _Certificate) -> Certificate:
    figures = {name: value for name, value in model if name != "seal"}
    return Certificate(**{**figures, "checks": tuple(model.checks)})
