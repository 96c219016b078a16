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
    """Write a roadmap. The same roadmap gives the same bytes.

    Args:
        path: The file.
        roadmap: The roadmap.
        fingerprint: Fingerprint of the cell that it is valid for.
        made: How it was built, as JSON values.
        gaps: Gaps that the build left.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written.
    """
    content = roadmap_content(roadmap, fingerprint, made, gaps or RoadmapGaps())
    write_content(path, ROADMAP, content, replace)


def read_roadmap(path: Path, cell: Cell | None = None) -> Roadmap:
    """Read a roadmap.

    Args:
        path: The file.
        cell: The cell that it must have been made for; None for any.

    Returns:
        The roadmap.

    Raises:
        InputError: The file is missing or of another kind.
        DamagedError: Its content is not what was written.
        StaleError: It was made for another cell or by another version of the format.
    """
    with stored_file(path, ROADMAP, _fingerprint(cell)) as file:
        roadmap = roadmap_of(file)
        validate.roadmap(roadmap, cell)
        return roadmap


def read_gaps(path: Path) -> RoadmapGaps:
    """Read the gaps that the build of a roadmap left.

    Args:
        path: The file of the roadmap.

    Returns:
        Configurations and pairs, each with the reason.

    Raises:
        InputError: The file is missing or of another kind.
        DamagedError: Its content is not what was written.
        StaleError: It was made by another version of the format.
    """
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
    """Write a trajectory database with its timed points. The same database gives the same bytes.

    Args:
        path: The file.
        database: The motions, with their timed points.
        fingerprint: Fingerprint of the cell that they are valid for.
        made: How the database was built, as JSON values.
        missing: Motions that the build did not find.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written.
        ValueError: The database was loaded without its timed points.
    """
    write_content(path, DATABASE, database_content(database, fingerprint, made, missing), replace)


def read_database(path: Path, cell: Cell | None = None, points: bool = False) -> TrajectoryDatabase:
    """Read a trajectory database.

    Args:
        path: The file.
        cell: The cell that it must have been made for; None for any.
        points: Whether to read the timed points as well; queries need only the paths.

    Returns:
        The database.

    Raises:
        InputError: The file is missing or of another kind.
        DamagedError: Its content is not what was written.
        StaleError: It was made for another cell or by another version of the format.
    """
    with stored_file(path, DATABASE, _fingerprint(cell)) as file:
        database = database_of(file, points)
        validate.database(database, cell)
        return database


def read_missing(path: Path) -> tuple[Missing, ...]:
    """Read the motions that the build of a database did not find.

    Args:
        path: The file of the database.

    Returns:
        The motions, each with the reason.

    Raises:
        InputError: The file is missing or of another kind.
        DamagedError: Its content is not what was written.
        StaleError: It was made by another version of the format.
    """
    with stored_file(path, DATABASE) as file:
        return missing_of(file)


def read_motion(path: Path, key: MotionKey, cell: Cell | None = None) -> CoarseMotion | None:
    """Read one motion with its timed points; the others are not read.

    For callers that need single motions; queries read the whole database without timed points. Damage in
    other rows is not noticed.

    Args:
        path: The file of the database.
        key: Ends and payload class of the motion.
        cell: The cell that the file must have been made for; None for any.

    Returns:
        The motion, reversed if necessary, or None if it is not stored.

    Raises:
        InputError: The file is missing or of another kind.
        DamagedError: The data that were read are not those that were written.
        StaleError: It was made for another cell or by another version of the format.
    """
    with stored_file(path, DATABASE, _fingerprint(cell)) as file:
        for wanted in (key, key.reversed()):
            row = row_of(file, wanted)
            if row is not None:
                motion = _checked_motion(file, row, cell)
                return motion if wanted == key else motion.reversed()
    return None


def surveyed(path: Path, cell: Cell | None = None) -> IntegrityReport:
    """Scan every byte of a roadmap or database for damage, and check the consistency of the intact content.

    Args:
        path: The file.
        cell: The cell whose tool states the file must have, if it was made for this cell.

    Returns:
        The damaged and the intact parts.

    Raises:
        InputError: The file is missing or of another kind.
        StaleError: It was made by another version of the format.
        DamagedError: Nothing can be recovered, or the intact content is inconsistent: then no row can be
            trusted.
    """
    found = scan_integrity(path, FORMATS)
    try:
        check_intact(found, cell)
    except SYMPTOMS as error:
        raise DamagedError(
            f"{path}: its checksums are right, but its content is invalid ({cause_of(error)}); build it again"
        ) from None
    return found


def describe(path: Path) -> dict[str, Any]:
    """Read the metadata of a file: format, version, fingerprint, provenance, and number of rows.

    Args:
        path: A roadmap or trajectory database.

    Returns:
        JSON values by name.

    Raises:
        InputError: The file is missing or of another kind.
        DamagedError: Its content is not what was written.
    """
    kind = kind_of(path)
    with stored_file(path, kind) as file:
        for name in kind.owners:
            file.pieces(name)  # validates their checksums
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


def read_provenance(path: Path) -> dict[str, Any]:
    """Read the provenance that is recorded in a file.

    Args:
        path: A roadmap or trajectory database.

    Returns:
        JSON values by name.

    Raises:
        InputError: The file is missing or of another kind.
        DamagedError: Its content is not what was written.
    """
    with stored_file(path, kind_of(path)) as file:
        return file.made


def kind_of(path: Path) -> FileFormat:
    """Return the format of a file.

    Args:
        path: The file.

    Returns:
        The format of a roadmap or of a trajectory database.

    Raises:
        InputError: The file is missing or of another kind.
        DamagedError: It cannot be read.
    """
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
