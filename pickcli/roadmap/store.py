"""Roadmaps and trajectory databases as HDF5 files. See docs/formats/hdf5.md."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.model import Cell
from pickcli.cell.robot import PivotState
from pickcli.errors import DamagedError, InputError
from pickcli.roadmap import validate
from pickcli.roadmap.database import MotionKey, PayloadClass, TimedPoints, TrajectoryDatabase
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.hdf5_format import ANY_WIDTH, TEXT, AnyArray, Column, Content, Format
from pickcli.roadmap.hdf5_read import opened, read_attributes, read_content
from pickcli.roadmap.hdf5_write import to_bytes, write_content

_NUMBERS, _ROWS, _INDICES, _NAMES = Column("<f8"), Column("<f8", ANY_WIDTH), Column("<i8"), Column(TEXT)

ROADMAP = Format(
    "roadmap",
    1,
    {
        "joint_names": _NAMES,
        "configurations": _ROWS,
        "names": _NAMES,
        "pivots": _NAMES,
        "edges": Column("<i8", 2),
        "lengths": _NUMBERS,
        "waypoints": _ROWS,
        "offsets": _INDICES,
        "proven_for": _NAMES,
    },
)

_POINTS = ("times", "positions", "velocities", "accelerations", "point_offsets")

DATABASE = Format(
    "trajectory database",
    1,
    {
        "joint_names": _NAMES,
        "starts": _NAMES,
        "goals": _NAMES,
        "payloads": _NAMES,
        "pivots": _NAMES,
        "durations": _NUMBERS,
        "waypoints": _ROWS,
        "offsets": _INDICES,
        "times": _NUMBERS,
        "positions": _ROWS,
        "velocities": _ROWS,
        "accelerations": _ROWS,
        "point_offsets": _INDICES,
    },
)


def write_roadmap(path: Path, roadmap: Roadmap, fingerprint: str, made: Mapping[str, Any]) -> None:
    """Write a roadmap that is valid for the cell of that fingerprint; ``made`` says how it was built.

    The same roadmap gives the same bytes. Raises InputError if the place cannot be written.
    """
    write_content(path, ROADMAP, _roadmap_content(roadmap, fingerprint, made))


def roadmap_bytes(roadmap: Roadmap, fingerprint: str, made: Mapping[str, Any]) -> bytes:
    """The bytes that ``write_roadmap`` writes."""
    return to_bytes(ROADMAP, _roadmap_content(roadmap, fingerprint, made))


def read_roadmap(path: Path, cell: Cell | None = None) -> Roadmap:
    """Read a roadmap; with ``cell``, only if it was made for it.

    Raises InputError (missing, another kind of file), DamagedError, StaleError.
    """
    content = read_content(path, ROADMAP, None if cell is None else cell.fingerprint)
    a = content.arrays
    try:
        (proven_for,) = (PivotState(text) for text in _texts(a["proven_for"]))
        pivots = tuple(PivotState(text) for text in _texts(a["pivots"]))
        roadmap = Roadmap(
            _texts(a["joint_names"]), a["configurations"], _texts(a["names"]), pivots,
            a["edges"], a["lengths"], a["waypoints"], a["offsets"], proven_for,
        )  # fmt: skip
        validate.roadmap(roadmap, cell)
    except ValueError as error:
        raise DamagedError(f"{path}: damaged ({error}); delete it and build it again") from None
    return roadmap


def write_database(
    path: Path, database: TrajectoryDatabase, fingerprint: str, made: Mapping[str, Any]
) -> None:
    """Write a trajectory database with its timed points; like ``write_roadmap``."""
    write_content(path, DATABASE, _database_content(database, fingerprint, made))


def read_database(path: Path, cell: Cell | None = None, points: bool = False) -> TrajectoryDatabase:
    """Read a trajectory database, with its timed points only if asked: queries need the paths alone.

    Raises InputError (missing, another kind of file), DamagedError, StaleError.
    """
    fingerprint = None if cell is None else cell.fingerprint
    a = read_content(path, DATABASE, fingerprint, without=() if points else _POINTS).arrays
    try:
        keys = tuple(
            MotionKey(start, goal, PayloadClass(payload))
            for start, goal, payload in zip(
                _texts(a["starts"]), _texts(a["goals"]), _texts(a["payloads"]), strict=True
            )
        )
        timed = TimedPoints(*(a[name] for name in _POINTS)) if points else None
        pivots = tuple(PivotState(text) for text in _texts(a["pivots"]))
        database = TrajectoryDatabase(
            _texts(a["joint_names"]), keys, pivots, a["durations"], a["waypoints"], a["offsets"], timed
        )
        validate.database(database, cell)
    except ValueError as error:
        raise DamagedError(f"{path}: damaged ({error}); delete it and build it again") from None
    return database


def describe(path: Path) -> dict[str, Any]:
    """What a file says of itself: format, version, fingerprint, how it was made, and how much it holds.

    Raises InputError for a file that is neither roadmap nor database, DamagedError.
    """
    with opened(path) as file:
        name = read_attributes(file).get("format")
    kind = next((kind for kind in (ROADMAP, DATABASE) if kind.name == name), None)
    if kind is None:
        raise InputError(f"{path}: neither a roadmap nor a trajectory database; name another")
    content = read_content(path, kind)
    return {
        "format": kind.name,
        "version": kind.version,
        "cell_fingerprint": content.fingerprint,
        "made": dict(content.made),
        "arrays": {name: list(array.shape) for name, array in content.arrays.items()},
    }


def _roadmap_content(roadmap: Roadmap, fingerprint: str, made: Mapping[str, Any]) -> Content:
    arrays = {
        "joint_names": _bytes(roadmap.joint_names),
        "configurations": roadmap.configurations,
        "names": _bytes(roadmap.names),
        "pivots": _bytes(roadmap.pivots),
        "edges": roadmap.edges,
        "lengths": roadmap.lengths,
        "waypoints": roadmap.waypoints,
        "offsets": roadmap.offsets,
        "proven_for": _bytes([roadmap.proven_for]),
    }
    return Content(fingerprint, made, arrays)


def _database_content(database: TrajectoryDatabase, fingerprint: str, made: Mapping[str, Any]) -> Content:
    points = database.points
    if points is None:
        raise ValueError("a database without its timed points cannot be written")
    arrays = {
        "joint_names": _bytes(database.joint_names),
        "starts": _bytes([key.start for key in database.keys]),
        "goals": _bytes([key.goal for key in database.keys]),
        "payloads": _bytes([key.payload for key in database.keys]),
        "pivots": _bytes(database.pivots),
        "durations": database.durations,
        "waypoints": database.waypoints,
        "offsets": database.offsets,
        "times": points.times,
        "positions": points.positions,
        "velocities": points.velocities,
        "accelerations": points.accelerations,
        "point_offsets": points.offsets,
    }
    return Content(fingerprint, made, arrays)


def _bytes(texts: Sequence[str]) -> NDArray[np.bytes_]:
    return np.array([str(text).encode() for text in texts] or np.zeros(0), dtype="S")


def _texts(array: AnyArray) -> tuple[str, ...]:
    return tuple(bytes(text).decode() for text in array)
