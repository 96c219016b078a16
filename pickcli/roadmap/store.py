"""Roadmaps and trajectory databases as HDF5 files. See docs/formats/hdf5.md."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pickcli.cell.cell import Cell
from pickcli.errors import DamagedError, InputError
from pickcli.roadmap import validate
from pickcli.roadmap.database_tables import (
    DATABASE,
    Missing,
    database_content,
    database_of,
    missing_of,
    motion_of,
    row_of,
)
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.recovered_content import check_intact
from pickcli.roadmap.roadmap_tables import ROADMAP, RoadmapGaps, gaps_of, roadmap_content, roadmap_of
from pickcli.roadmap.trajectory_database import CoarseMotion, MotionKey, TrajectoryDatabase
from pickcli.storage.integrity_scan import IntegrityReport, scan_integrity
from pickcli.storage.safe_open import SYMPTOMS, cause_of, opened, read_attributes
from pickcli.storage.table_format import FileFormat
from pickcli.storage.table_reader import StoredFile, stored_file
from pickcli.storage.table_writer import write_content

FORMATS = (ROADMAP, DATABASE)


def write_roadmap(
    path: Path,
    roadmap: Roadmap,
    fingerprint: str,
    made: Mapping[str, Any],
    gaps: RoadmapGaps | None = None,
    replace: bool = True,
) -> None:
    """Write a roadmap that is valid for the cell of that fingerprint; ``made`` says how it was built.

    The same roadmap gives the same bytes. ``replace``: whether a file that is there may be replaced.
    Raises InputError if the place cannot be written.
    """
    content = roadmap_content(roadmap, fingerprint, made, gaps or RoadmapGaps())
    write_content(path, ROADMAP, content, replace)


def read_roadmap(path: Path, cell: Cell | None = None) -> Roadmap:
    """Read a roadmap; with ``cell``, only if it was made for it.

    Raises InputError (missing, another kind of file), DamagedError, StaleError.
    """
    with stored_file(path, ROADMAP, _fingerprint(cell)) as file:
        roadmap = roadmap_of(file)
        validate.roadmap(roadmap, cell)
        return roadmap


def read_gaps(path: Path) -> RoadmapGaps:
    """What the build of a roadmap could not have. Raises like ``read_roadmap``."""
    with stored_file(path, ROADMAP) as file:
        return gaps_of(file)


def write_database(
    path: Path,
    database: TrajectoryDatabase,
    fingerprint: str,
    made: Mapping[str, Any],
    missing: Sequence[Missing] = (),
    replace: bool = True,
) -> None:
    """Write a trajectory database with its timed points; like ``write_roadmap``."""
    write_content(path, DATABASE, database_content(database, fingerprint, made, missing), replace)


def read_database(path: Path, cell: Cell | None = None, points: bool = False) -> TrajectoryDatabase:
    """Read a trajectory database, with its timed points only if asked: queries need the paths alone.

    Raises InputError (missing, another kind of file), DamagedError, StaleError.
    """
    with stored_file(path, DATABASE, _fingerprint(cell)) as file:
        database = database_of(file, points)
        validate.database(database, cell)
        return database


def read_missing(path: Path) -> tuple[Missing, ...]:
    """What the build of a database could not have. Raises like ``read_database``."""
    with stored_file(path, DATABASE) as file:
        return missing_of(file)


def read_motion(path: Path, key: MotionKey, cell: Cell | None = None) -> CoarseMotion | None:
    """One motion with its timed points, turned round if need be, or None; the others are not read.

    For those who need single motions out of many: queries read the whole database, without its points.
    Raises like ``read_database``; damage elsewhere in the data does not matter.
    """
    with stored_file(path, DATABASE, _fingerprint(cell)) as file:
        for wanted in (key, key.reversed()):
            row = row_of(file, wanted)
            if row is not None:
                motion = _checked_motion(file, row, cell)
                return motion if wanted == key else motion.reversed()
    return None


def surveyed(path: Path, cell: Cell | None = None) -> IntegrityReport:
    """Look at every byte of a roadmap or database: what is damaged, and what is intact and makes sense.

    cell: whose states of the tool it may speak of, if it was made for this cell
    Raises like ``scan_integrity``; DamagedError, too, if what is intact makes no sense: then no row can be
    trusted.
    """
    found = scan_integrity(path, FORMATS)
    try:
        check_intact(found, cell)
    except SYMPTOMS as error:
        raise DamagedError(
            f"{path}: its checksums are right, but what it holds makes no sense ({cause_of(error)}); "
            "build it again"
        ) from None
    return found


def describe(path: Path) -> dict[str, Any]:
    """What a file says of itself: format, version, fingerprint, how it was made, and how much it holds.

    Raises InputError for a file that is neither roadmap nor database, DamagedError.
    """
    kind = kind_of(path)
    with stored_file(path, kind) as file:
        for name in kind.owners:
            file.pieces(name)  # proves them
        return {
            "format": kind.name,
            "version": kind.version,
            "cell_fingerprint": file.fingerprint,
            "made": dict(file.made),
            "rows": {
                **{name: len(table) for name, table in file.tables.items()},
                **{name: len(dataset) for name, dataset in file.datasets.items()},
            },
        }


def how_made(path: Path) -> dict[str, Any]:
    """What a file says of how it was made: JSON values. Raises like ``describe``."""
    with stored_file(path, kind_of(path)) as file:
        return file.made


def kind_of(path: Path) -> FileFormat:
    """Which of our formats a file has. Raises InputError for another, DamagedError."""
    with opened(path) as file:
        name = read_attributes(file).get("format")
    for kind in FORMATS:
        if kind.name == name:
            return kind
    raise InputError(f"{path}: neither a roadmap nor a trajectory database; name another")


def _fingerprint(cell: Cell | None) -> str | None:
    return None if cell is None else cell.fingerprint


def _checked_motion(file: StoredFile, row: int, cell: Cell | None) -> CoarseMotion:
    pieces = (file.piece(name, row) for name in ("waypoints", "points"))
    motion = motion_of(file.joint_names, file.tables["motions"][row], *pieces)
    validate.database(TrajectoryDatabase.of(file.joint_names, [motion]), cell)
    return motion
