"""Cache of the precomputed files of cells: their paths, and building of missing files."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from platformdirs import user_cache_path

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import cell_names, load_workcell
from pickcli.errors import ArtifactError, InputError
from pickcli.jobs.executors import Executor, SerialExecutor
from pickcli.jobs.job_run import BuildObserver, RunOptions
from pickcli.jobs.journal import journals
from pickcli.precompute.artifact_files import make_roadmap, make_trajectories
from pickcli.precompute.provenance import configurations_digest
from pickcli.precompute.repair import repair
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.store import read_database, read_provenance, read_roadmap, surveyed
from pickcli.roadmap.trajectory_database import TrajectoryDatabase


@dataclass(frozen=True)
class Artifacts:
    """Paths of a cell's precomputed files; they need not exist.

    Attributes:
        roadmap: Path of the roadmap.
        trajectories: Path of the trajectory database.
    """

    roadmap: Path
    trajectories: Path


@dataclass(frozen=True)
class CachedFolder:
    """A folder of the cache.

    Attributes:
        name: Name of the folder: for a cell, its fingerprint.
        cell: Name of the cell under data/cells that has this fingerprint, "" if none has.
        n_files: Number of files in it.
        n_bytes: Total size of these files.
    """

    name: str
    cell: str
    n_files: int
    n_bytes: int


def cache_folder() -> Path:
    """Return the folder of the user's cache: $XDG_CACHE_HOME/apc, ~/.cache/apc by default.

    Returns:
        The folder, which need not exist.

    Raises:
        InputError: This user has no home folder.
    """
    try:
        return user_cache_path("apc", appauthor=False)
    except RuntimeError:  # e.g. a user without an entry in a container
        raise InputError(
            "this user has no home folder for the cache of built files; set HOME or XDG_CACHE_HOME"
        ) from None


def cached(base: Path) -> list[CachedFolder]:
    """List the content of the cache.

    Args:
        base: Folder of the cache, which need not exist.

    Returns:
        Its folders, by name.
    """
    names = {
        cell.fingerprint: f"{name}, arm {arm}" if arm else name
        for name in cell_names()
        for arm, cell in load_workcell(name).arms.items()
    }
    found = []
    for folder in sorted(path for path in base.glob("*") if path.is_dir()):
        sizes = [path.stat().st_size for path in folder.rglob("*") if path.is_file()]
        found.append(CachedFolder(folder.name, names.get(folder.name, ""), len(sizes), sum(sizes)))
    return found


def clear_cache(base: Path) -> None:
    """Delete every folder of the cache.

    Args:
        base: Folder of the cache, which is kept and need not exist.

    Raises:
        InputError: Something cannot be deleted.
    """
    for folder in [path for path in base.glob("*") if path.is_dir()]:
        try:
            shutil.rmtree(folder)
        except OSError as error:
            raise InputError(f"{folder}: cannot be deleted: {error.strerror}") from None


def default_paths(cell: Cell) -> Artifacts:
    """Return the paths of a cell's files in the user's cache.

    The folder's name is the fingerprint, so that a changed cell never finds stale files.

    Args:
        cell: The cell.

    Returns:
        The paths.

    Raises:
        InputError: This user has no home folder.
    """
    folder = cache_folder() / cell.fingerprint
    return Artifacts(folder / "roadmap.h5", folder / "trajectories.h5")


def read_stored(
    cell: Cell, roadmap: Path | None, trajectories: Path | None
) -> tuple[Roadmap | None, TrajectoryDatabase | None]:
    """Read the precomputed files of a cell: the named ones, else those in the cache, if built.

    Args:
        cell: The cell.
        roadmap: Path of the roadmap, None for the cached one.
        trajectories: Path of the trajectory database, None for the cached one.

    Returns:
        Roadmap and trajectory database, None if there is none.

    Raises:
        InputError: A named file is missing.
        StaleError: A file was made for another cell or by another version of the format.
        DamagedError: The content of a file is not what was written.
    """
    built = default_paths(cell)
    roadmap = roadmap or (built.roadmap if built.roadmap.exists() else None)
    trajectories = trajectories or (built.trajectories if built.trajectories.exists() else None)
    return (
        None if roadmap is None else read_roadmap(roadmap, cell),
        None if trajectories is None else read_database(trajectories, cell),
    )


def ensure_artifacts(
    cell: Cell,
    report: Callable[[str], BuildObserver] | None = None,
    runner: Executor | None = None,
) -> Artifacts:
    """Make sure that a cell's files are in the cache.

    Missing or stale files are built with default settings, damaged ones are repaired.

    Args:
        cell: The cell.
        report: Called with the name of what is built, returns the observer of that build; None for silence.
        runner: Executor of the tasks; None for this process.

    Returns:
        The paths of the existing files.

    Raises:
        InputError: The cache cannot be written.
    """
    paths = default_paths(cell)
    _make_folder(paths.roadmap.parent)
    for what, read, make, path in (
        ("roadmap", read_roadmap, make_roadmap, paths.roadmap),
        ("trajectories", read_database, make_trajectories, paths.trajectories),
    ):
        if not _is_usable(read, path, cell):
            run_options = RunOptions(runner or SerialExecutor(), report=report and report(what))
            if not _is_repaired(path, cell, run_options):
                make(cell, path, run_options=run_options)
            for journal in journals(path):  # of older versions: builds here always have the default settings
                journal.unlink(missing_ok=True)
    return paths


def _is_usable(read: Callable[[Path, Cell], Any], path: Path, cell: Cell) -> bool:
    """Whether a file can be read and was made for the cell's current named configurations."""
    try:
        read(path, cell)
        return bool(read_provenance(path).get("configurations") == configurations_digest(cell))
    except (ArtifactError, InputError):
        return False


def _is_repaired(path: Path, cell: Cell, run_options: RunOptions) -> bool:
    """Repair a file, if it has a known format and enough of it is intact; return whether that succeeded."""
    try:
        found = surveyed(path, cell)
        return bool(found.damage) and repair(path, found, cell, run_options).is_same
    except (ArtifactError, InputError):
        return False


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"{folder}: cannot be made: {error.strerror}; set XDG_CACHE_HOME elsewhere"
        ) from None
