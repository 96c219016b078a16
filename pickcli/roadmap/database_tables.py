"""Tables of a trajectory database in its file. See docs/formats/hdf5.md."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pickcli.cell.tool import ToolState
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.path import JointPath
from pickcli.motion.trajectory import Trajectory
from pickcli.roadmap.common_columns import (
    VALIDITY,
    reason_columns,
    reason_row,
    reason_rows,
    reason_table,
    row_validity,
    validities_of,
    validity_columns,
)
from pickcli.roadmap.trajectory_database import (
    CoarseMotion,
    MotionKey,
    PayloadClass,
    TimedPoints,
    TrajectoryDatabase,
)
from pickcli.storage.table_format import NUMBER, TEXT, Columns, FileContent, FileFormat, Table
from pickcli.storage.table_reader import StoredFile

Missing = tuple[MotionKey, Reason]  # a motion that was not found, and why

NAMES = ("start", "goal", "payload")

DATABASE = FileFormat(
    "trajectory database",
    4,
    {
        "motions": Table(
            {
                **dict.fromkeys((*NAMES, "tool_state", *VALIDITY), TEXT),
                **dict.fromkeys(("duration", "lower_bound", "clearance"), NUMBER),
            },
            pieces=("waypoints", "points"),
        ),
        "missing": reason_table(*NAMES),
    },
)


def database_content(
    database: TrajectoryDatabase, fingerprint: str, made: Mapping[str, Any], missing: Sequence[Missing]
) -> FileContent:
    """Lay out a database with its timed points as the content of its file.

    Args:
        database: The motions.
        fingerprint: Fingerprint of the motions' cell.
        made: How the database was built, as JSON values.
        missing: Motions that the build did not find.

    Returns:
        The content to be written.

    Raises:
        ValueError: The database was loaded without its timed points.
    """
    if database.points is None:
        raise ValueError("a database without its timed points cannot be written")
    motions = list(database)
    tables: dict[str, Columns] = {
        "motions": {
            **{name: [getattr(key, name) for key in database.keys] for name in NAMES},
            "tool_state": database.tool_states,
            **validity_columns(database.validities),
            "duration": database.durations,
            "lower_bound": database.lower_bounds,
            "clearance": database.clearances,
        },
        "missing": reason_columns(NAMES, [((k.start, k.goal, k.payload), reason) for k, reason in missing]),
    }
    pieces = {
        "waypoints": [motion.path.waypoints for motion in motions],
        "points": [_points(motion.trajectory) for motion in motions if motion.trajectory is not None],
    }
    return FileContent(fingerprint, made, database.joint_names, tables, pieces)


def database_of(file: StoredFile, points: bool) -> TrajectoryDatabase:
    """Read all motions of a file.

    Args:
        file: The open file.
        points: Whether to read the timed points as well.

    Returns:
        The database; its ``points`` are None unless requested.

    Raises:
        ValueError: The content is inconsistent.
    """
    table = file.tables["motions"]
    waypoints, offsets = file.pieces("waypoints")
    keys = tuple(MotionKey(a, b, PayloadClass(load)) for a, b, load in zip(
        *(file.texts("motions", name) for name in NAMES), strict=True
    ))  # fmt: skip
    return TrajectoryDatabase(
        file.joint_names,
        keys,
        tuple(ToolState(text) for text in file.texts("motions", "tool_state")),
        table["duration"],
        waypoints,
        offsets,
        table["lower_bound"],
        table["clearance"],
        validities_of(file, "motions"),
        _timed_points(file) if points else None,
    )


def row_of(file: StoredFile, key: MotionKey) -> int | None:
    """Find the row of a motion in its stored direction.

    Args:
        file: The open file.
        key: Ends and payload class of the motion.

    Returns:
        Index of the row, or None if there is no such motion.
    """
    table = file.tables["motions"]
    wanted = [(table[name] == str(getattr(key, name)).encode()) for name in NAMES]
    rows = np.flatnonzero(np.logical_and.reduce(wanted))
    return int(rows[0]) if len(rows) else None


def motion_of(joint_names: tuple[str, ...], row: Any, waypoints: Array, points: Array) -> CoarseMotion:
    """Make one motion from its row of the table and its pieces.

    Args:
        joint_names: Names of the n joints.
        row: Record of the table of motions.
        waypoints: (K, n) of its path.
        points: (P, 1 + 3 n) time in s, positions, velocities and accelerations side by side.

    Returns:
        The motion.

    Raises:
        ValueError: A name is unknown, or the points have a wrong number of columns.
    """
    start, goal, payload, tool_state = (bytes(row[name]).decode() for name in (*NAMES, "tool_state"))
    return CoarseMotion(
        MotionKey(start, goal, PayloadClass(payload)),
        ToolState(tool_state),
        JointPath(joint_names, waypoints),
        float(row["duration"]),
        Trajectory(joint_names, *_parts(points)),
        float(row["lower_bound"]),
        float(row["clearance"]),
        row_validity(row),
    )


def missing_of(file: StoredFile) -> tuple[Missing, ...]:
    """Read the motions that the build of a database did not find.

    Args:
        file: The open file.

    Returns:
        The motions, each with the reason.
    """
    return tuple(_missing(names, reason) for names, reason in reason_rows(NAMES, file.tables["missing"]))


def missing_row(row: Any) -> Missing:
    """Read one row of the table of missing motions.

    Args:
        row: Record of the table.

    Returns:
        The motion that was not found, and the reason.
    """
    return _missing(*reason_row(NAMES, row))


def _missing(names: Sequence[str], reason: Reason) -> Missing:
    return MotionKey(names[0], names[1], PayloadClass(names[2])), reason


def _points(timed: Trajectory) -> Array:
    """Return (P, 1 + 3 n): time, positions, velocities, accelerations side by side."""
    return np.column_stack([timed.times, timed.positions, timed.velocities, timed.accelerations])


def _parts(points: Array) -> tuple[Array, Array, Array, Array]:
    """Split into times (P,), positions, velocities, accelerations (P, n each). Raises ValueError."""
    n, rest = divmod(points.shape[1] - 1, 3)
    if rest:
        raise ValueError(f"timed points of {points.shape[1]} columns")
    blocks = (np.ascontiguousarray(points[:, 1 + i * n : 1 + (i + 1) * n]) for i in range(3))
    return (np.ascontiguousarray(points[:, 0]), *blocks)  # type: ignore[return-value]


def _timed_points(file: StoredFile) -> TimedPoints:
    points, offsets = file.pieces("points")
    return TimedPoints(*_parts(points), offsets)
