"""Stores the motion of a trial in a file for replay: joints, items, vacuum and executions.

Samples are thinned such that linear interpolation of the kept ones is within stated bounds of all others. See
docs/formats/trial.md for the format.
"""

from __future__ import annotations

import gzip
import json
import zlib
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from pickcli.cell.cell import Cell
from pickcli.cell.robot import Robot
from pickcli.cell.tool import MOVING, ToolState
from pickcli.errors import InputError, StaleError
from pickcli.files.atomic_write import write_bytes
from pickcli.files.bounded_reading import read_bytes
from pickcli.files.packed_array import packed
from pickcli.files.source import name_of
from pickcli.geometry import Array
from pickcli.motion.limit_shares import limit_shares
from pickcli.motion.segment import Segment
from pickcli.scene.scene import Scene
from pickcli.simulation.motion_recorder import LOOK_TIME, MotionRecorder, RecordedRun
from pickcli.trial.motion_schema import (
    MAX_JOINT,
    MAX_PRESSURE,
    MAX_SHARE,
    ExecutionModel,
    MotionModel,
    PackedModel,
)
from pickcli.trial.trial_perception import LOOK_FROM
from pickcli.trial.trial_record import record_digest

FORMAT, VERSION = "apc motion", 1
MAX_BYTES = 16 * 2**20
MAX_TEXT = 4 * MAX_BYTES  # uncompressed
OTHER_TRIAL = "is the motion of another trial, or the record was changed since; play the trial again"
SLACK = 0.002  # s, tolerance for rounded times of segments

JOINT_BOUND = 1e-3  # rad or m, error bound of a replayed joint at a sample
POSITION_BOUND = 1e-3  # m, of an item
TURN_BOUND = 2e-3  # of a quaternion's elements
VACUUM_BOUND = 300.0  # Pa
_TIME, _JOINT, _POSE, _VACUUM, _SHARE = 1e-3, 1e-4, 1e-4, 50.0, 0.01  # units for rounding


@dataclass(frozen=True, eq=False)
class RecordedExecution:
    """Execution of one plan, or a release.

    Attributes:
        query: The planned query.
        arm: Name of the arm that moved; empty in a cell with one arm.
        t_start: s, simulated.
        t_end: s, simulated.
        segments: Executed segments of the plan, with their simulated times.
        times: (N,) s, simulated.
        shares: Planned velocity, acceleration and jerk, as shares of their limits, (N, n) each.
    """

    query: str
    arm: str
    t_start: float
    t_end: float
    segments: tuple[Segment, ...]
    times: Array
    shares: tuple[Array, ...]


@dataclass(frozen=True, eq=False)
class RecordedMotion:
    """Recorded motion of a trial.

    Attributes:
        arms: Names of the arms that play; empty for a single arm.
        joint_names: Names of the m joints: of each arm the planned ones, then those of its tool.
        times: (N,) s, simulated.
        joints: (N, m) rad or m, as measured.
        vacuum_times: (K,) s.
        vacuum: (K,) Pa below ambient in the cup; empty without vacuum.
        items: By id of moved items, times in s (M,) and poses (M, 7).
        executions: In order of time.
        record: Digest of the trial's record; empty before there is one.
    """

    arms: tuple[str, ...]
    joint_names: tuple[str, ...]
    times: Array
    joints: Array
    vacuum_times: Array
    vacuum: Array
    items: dict[str, tuple[Array, Array]]
    executions: tuple[RecordedExecution, ...]
    record: str = ""

    @property
    def of_attempts(self) -> tuple[RecordedExecution, ...]:
        """Executions of attempts: all but those that brought a camera to where it looks from."""
        return tuple(each for each in self.executions if not each.query.startswith(LOOK_FROM))


def motion_values(recorder: MotionRecorder, cells: Sequence[Cell]) -> dict[str, Any]:
    """Convert a recording to JSON values.

    Args:
        recorder: The recorder of the world.
        cells: The cell as seen by each arm that plays.

    Returns:
        Values by name.
    """
    times, joints = np.array(recorder.times), np.array(recorder.joints)
    pressure = np.array(recorder.vacuum)[:, None]
    of_joints = thinned(times, joints, np.full(joints.shape[1], JOINT_BOUND))
    of_vacuum = thinned(times, pressure, np.array([VACUUM_BOUND])) if pressure.any() else np.zeros(0, np.intp)
    by_arm = {cell.arm: cell for cell in cells}
    moved = [(name, rows) for name, rows in sorted(recorder.items.items()) if _has_moved(np.array(rows))]
    return {
        "format": FORMAT,
        "version": VERSION,
        **({"arms": list(by_arm)} if len(by_arm) > 1 else {}),
        "joints": list(recorder.joint_names),
        "times": packed(times[of_joints], _TIME),
        "positions": packed(joints[of_joints], _JOINT),
        "vacuum": {
            "times": packed(times[of_vacuum], _TIME),
            "values": packed(pressure[of_vacuum, 0], _VACUUM),
        },
        "items": [_item(name, np.array(rows)) for name, rows in moved],
        "executions": [_execution(run, by_arm[run.arm]) for run in recorder.runs],
    }  # fmt: skip


def write_motion(path: Path, values: Mapping[str, Any], replace: bool = True) -> None:
    """Write recorded values as gzip-compressed JSON. Equal values give equal bytes.

    Args:
        path: The file.
        values: JSON values by name.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written.
    """
    text = json.dumps(values, separators=(",", ":"), allow_nan=False)
    write_bytes(path, gzip.compress(text.encode(), compresslevel=9, mtime=0), replace)


def read_motion(path: Path) -> RecordedMotion:
    """Read a recorded motion.

    Args:
        path: The file.

    Returns:
        The motion.

    Raises:
        InputError: The file cannot be read, or is not such a file.
    """
    content = read_bytes(path, MAX_BYTES, "apc run-trial writes one")
    try:
        model = MotionModel.model_validate_json(_unzipped(content))
        motion = _read(model)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        cause = f"{name_of(first['loc']) or 'the text'}: {first['msg']}"
        raise InputError(f"{path}: is no motion of a trial ({cause}); play the trial again") from None
    except (OSError, EOFError, zlib.error, ValueError) as error:
        raise InputError(f"{path}: is no motion of a trial ({error}); play the trial again") from error
    return motion


def read_motion_of(path: Path, record: Mapping[str, Any]) -> RecordedMotion:
    """Read the recorded motion of a trial.

    Args:
        path: The file.
        record: Record of the trial.

    Returns:
        The motion.

    Raises:
        InputError: The file cannot be read, or is not such a file.
        StaleError: It is of another trial, or the record was changed since.
    """
    motion = read_motion(path)
    if motion.record != record_digest(record):
        raise StaleError(f"{path}: {OTHER_TRIAL}")
    return motion


def parse_motion(values: Mapping[str, Any]) -> RecordedMotion:
    """Convert JSON values to a recorded motion, as if they had been written and read.

    Args:
        values: Values by name, of ``motion_values``.

    Returns:
        The motion.
    """
    return _read(MotionModel.model_validate_json(json.dumps(values)))


def refuse_other_motion(
    motion: RecordedMotion, scene: Scene, cells: Sequence[Cell], where: str
) -> None:  # fmt: skip
    """Refuse a motion with names that a scene and its cell do not have, as it is from another trial.

    Args:
        motion: The motion.
        scene: The scene at the start.
        cells: The cell as seen by each arm that plays.
        where: Name of the motion's file, for messages.

    Raises:
        StaleError: The motion is from another scene or cell.
    """
    known, robots = {placed.id for placed in scene.items}, {cell.arm: cell.robot for cell in cells}
    joints = tuple(dict.fromkeys(name for robot in robots.values() for name in robot.moving_joints))
    if (
        motion.joint_names != joints
        or not motion.items.keys() <= known
        or not all(_is_known(execution, robots, known) for execution in motion.executions)
    ):
        raise StaleError(f"{where}: is the motion of another scene or cell; play the trial again")


def refuse_other_record(motion: RecordedMotion, record: Mapping[str, Any], where: str) -> None:
    """Refuse a motion that is not the one of a trial's record, as it is from another trial.

    Args:
        motion: The motion.
        record: Content of the trial's ``trial.json``.
        where: Name of the motion's file, for messages.

    Raises:
        StaleError: The motion has other executions, in number or by their queries; or it was recorded with
            another record.
    """
    stated: list[str | None] = []  # by execution its query; None where the record states none
    for attempt in record["attempts"]:
        stated += [None] * (attempt.get("parking") is not None)
        if attempt["execution"] is not None:
            stated.append((attempt.get("plan") or {}).get("query"))
        stated += [None for step in attempt["recovery"] if step["execution"] is not None]
    queries, found = (
        [execution.query for execution in executions]
        for executions in (motion.executions, motion.of_attempts)
    )
    n_looking = sum(look.get("motions", 0) for look in record.get("looks", ()))
    is_same_number = len(stated) == len(found) and n_looking == len(queries) - len(found)
    if is_same_number and all(s in (None, f) for s, f in zip(stated, found, strict=True)):
        if motion.record in ("", record_digest(record)):
            return
        raise StaleError(f"{where}: {OTHER_TRIAL}")
    n_stated = len(stated) + n_looking
    raise StaleError(
        f"{where}: is the motion of another trial: {len(queries)} executions{_first(queries)}, and the "
        f"record has {n_stated}{_first([s for s in stated if s])}; play the trial again"
    )


def _first(queries: Sequence[str]) -> str:
    return f", first {queries[0]!r}" if queries else ""


def _is_known(execution: RecordedExecution, robots: Mapping[str, Robot], items: Set[str]) -> bool:
    """Whether arm, tool states and held items of an execution are those of a cell and scene."""
    robot = robots.get(execution.arm)
    return robot is not None and (
        {segment.held for segment in execution.segments} <= {None, *items}
        and all(s.tool_state == MOVING or robot.tool.knows(s.tool_state) for s in execution.segments)
        and all(shares.shape[1] == robot.n_joints for shares in execution.shares)
    )


def thinned(times: Array, rows: Array, bounds: Array) -> NDArray[np.intp]:
    """Select rows such that linear interpolation between them is within bounds of all others.

    Args:
        times: (N,) s, increasing.
        rows: (N, k).
        bounds: (k,) error bounds.

    Returns:
        (M,) indices, including the first and the last row.
    """
    kept, low, high = [0], np.full(rows.shape[1], -np.inf), np.full(rows.shape[1], np.inf)
    for i in range(1, len(times)):
        slope = (rows[i] - rows[kept[-1]]) / (times[i] - times[kept[-1]])
        if ((slope < low) | (slope > high)).any():
            kept.append(i - 1)
            slope = (rows[i] - rows[i - 1]) / (times[i] - times[i - 1])
            low, high = np.full(rows.shape[1], -np.inf), np.full(rows.shape[1], np.inf)
        tolerance = bounds / (times[i] - times[kept[-1]])
        low, high = np.maximum(low, slope - tolerance), np.minimum(high, slope + tolerance)
    return np.array(kept if kept[-1] == len(times) - 1 else [*kept, len(times) - 1])


def _has_moved(rows: Array) -> bool:
    """Whether an item moved by more than the replay bounds."""
    off = np.abs(rows[:, 1:] - rows[0, 1:]).max(axis=0)
    return bool(off[:3].max() > POSITION_BOUND or off[3:].max() > TURN_BOUND)


def _item(name: str, rows: Array) -> dict[str, Any]:
    bounds = np.array([POSITION_BOUND] * 3 + [TURN_BOUND] * 4)
    kept = thinned(rows[:, 0], rows[:, 1:], bounds)
    return {"id": name, "times": packed(rows[kept, 0], _TIME), "poses": packed(rows[kept, 1:], _POSE)}


def _execution(run: RecordedRun, cell: Cell) -> dict[str, Any]:
    times = np.arange(run.t_start, run.t_end + LOOK_TIME, LOOK_TIME)
    plan = run.plan
    values = {"t_start": round(run.t_start, 3), "t_end": round(run.t_end, 3), "times": packed(times, _TIME)}
    if plan is None:
        return {"query": "let go", "arm": run.arm, **values, "segments": [], "shares": []}
    at = run.plan_time(times)
    shares = [
        packed(np.where(_is_moving(at)[:, None], limit_shares(plan.trajectory, cell, at, k), 0.0), _SHARE)
        for k in (1, 2, 3)
    ]
    segments = [
        [str(s.kind), *ends, str(s.tool_state), s.held, list(dict.fromkeys((*s.touching, *s.pushing)))]
        for s in plan.segments
        for ends in [[round(run.simulated_time(t), 3) for t in (s.t_start, s.t_end)]]
        if ends[1] > ends[0]
    ]
    return {"query": plan.query, "arm": plan.arm, **values, "segments": segments, "shares": shares}


def _unzipped(content: bytes) -> bytes:
    """Decompress text. Raises ValueError if it is larger than any that is written."""
    with gzip.open(BytesIO(content)) as file:
        text = file.read(MAX_TEXT + 1)
    if len(text) > MAX_TEXT:
        raise ValueError(f"its text has more than {MAX_TEXT} bytes")
    return text


def _read(model: MotionModel) -> RecordedMotion:
    """Build a motion from its file. Raises ValueError if arrays are inconsistent."""
    motion = RecordedMotion(
        model.arms, model.joints, model.times.times(), model.positions.rows(len(model.joints), MAX_JOINT),
        model.vacuum.times.times(), _column(model.vacuum.values),
        {item.id: (item.times.times(), item.poses.rows(7, MAX_JOINT)) for item in model.items},
        tuple(_read_execution(each) for each in model.executions), model.record,
    )  # fmt: skip
    columns = [(motion.times, motion.joints), *motion.items.values()]
    if any(len(times) == 0 or len(times) != len(rows) for times, rows in columns):
        raise ValueError("times that do not go with what moves")
    if len(motion.vacuum_times) != len(motion.vacuum):
        raise ValueError("times that do not go with the vacuum")
    started, ended = 0.0, dict[str, float]()  # ended: by arm, as several may move at the same time
    for each in motion.executions:
        after = max(started, ended.get(each.arm, 0.0))
        if not after <= each.t_start <= each.t_end:
            raise ValueError(f"an execution from {each.t_start} to {each.t_end} s, after {after} s")
        started, ended[each.arm] = each.t_start, each.t_end
    return motion


def _column(model: PackedModel) -> Array:
    """Vacuum (N,), which is stored without columns."""
    return model.model_copy(update={"shape": (*model.shape, 1)}).rows(1, MAX_PRESSURE)[:, 0]


def _read_execution(model: ExecutionModel) -> RecordedExecution:
    segments = tuple(
        Segment(kind, t_start, t_end, ToolState(state), held, touching)
        for kind, t_start, t_end, state, held, touching in model.segments
    )
    times, n = model.times.times(), model.shares[0].shape[-1] if model.shares else 0
    shares = tuple(each.rows(n, MAX_SHARE) for each in model.shares)
    if len(shares) not in (0, 3) or any(len(rows) != len(times) or not len(times) for rows in shares):
        raise ValueError("times that do not go with the limits")
    ends = [t for s in segments for t in (s.t_start, s.t_end)]
    if ends != sorted(ends) or not all(model.t_start - SLACK <= t <= model.t_end + SLACK for t in ends):
        raise ValueError("segments that do not follow each other")
    return RecordedExecution(model.query, model.arm, model.t_start, model.t_end, segments, times, shares)


def _is_moving(at: Array) -> NDArray[np.bool_]:
    """Mask (N,) of the times at which the plan's time advances."""
    return np.append(np.diff(at) > 0.0, False)
