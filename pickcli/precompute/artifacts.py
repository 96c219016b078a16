"""The precomputed files of a cell: where they lie, how they are made, and making what is missing."""

from __future__ import annotations

import importlib.metadata
import os
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from pickcli import __version__
from pickcli.cell.model import Cell
from pickcli.errors import ArtifactError, InputError
from pickcli.precompute.build_roadmap import RoadmapReport, RoadmapSettings, build_roadmap
from pickcli.precompute.build_trajectories import TrajectoryReport, build_trajectories
from pickcli.precompute.coarse_motion import TrajectorySettings
from pickcli.roadmap.store import read_database, read_roadmap, write_database, write_roadmap

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class Artifacts:
    """Paths of a cell's precomputed files; they need not exist."""

    roadmap: Path
    trajectories: Path


def default_paths(cell: Cell) -> Artifacts:
    """The cell's folder in the user's cache: $XDG_CACHE_HOME/apc/<fingerprint>, ~/.cache by default.

    The folder's name is the fingerprint, so that a changed cell finds nothing stale.
    """
    cache = os.environ.get("XDG_CACHE_HOME") or ""
    base = Path(cache) if os.path.isabs(cache) else Path.home() / ".cache"
    folder = base / "apc" / cell.fingerprint
    return Artifacts(folder / "roadmap.h5", folder / "trajectories.h5")


def make_roadmap(
    cell: Cell, path: Path, settings: RoadmapSettings | None = None, progress: Progress | None = None
) -> RoadmapReport:
    """Build a cell's roadmap and write it. Same cell and settings, same bytes."""
    roadmap, report = build_roadmap(cell, settings, progress)
    write_roadmap(path, roadmap, cell.fingerprint, _made(report.settings, report.summary()))
    return report


def make_trajectories(
    cell: Cell, path: Path, settings: TrajectorySettings | None = None, progress: Progress | None = None
) -> TrajectoryReport:
    """Build a cell's trajectory database and write it. Same cell and settings, same bytes."""
    database, report = build_trajectories(cell, settings, progress)
    write_database(path, database, cell.fingerprint, _made(report.settings, report.summary()))
    return report


def ensure_artifacts(cell: Cell, progress: Callable[[str], Progress] | None = None) -> Artifacts:
    """The cell's files in the cache; what is missing, damaged or stale is built with default settings.

    progress: called with what is about to be built, gives the callback for that build
    Raises InputError if the cache cannot be written.
    """
    paths = default_paths(cell)
    _make_folder(paths.roadmap.parent)
    if not _is_usable(read_roadmap, paths.roadmap, cell):
        make_roadmap(cell, paths.roadmap, progress=progress and progress("roadmap"))
    if not _is_usable(read_database, paths.trajectories, cell):
        make_trajectories(cell, paths.trajectories, progress=progress and progress("trajectories"))
    return paths


def _is_usable(read: Callable[[Path, Cell], Any], path: Path, cell: Cell) -> bool:
    try:
        read(path, cell)
    except (ArtifactError, InputError):
        return False
    return True


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"{folder}: cannot be made: {error.strerror}; set XDG_CACHE_HOME elsewhere"
        ) from None


def _made(settings: RoadmapSettings | TrajectorySettings, summary: dict[str, Any]) -> dict[str, Any]:
    """How a file was made: no times, no places, so that equal builds are equal bytes."""
    versions = {name: importlib.metadata.version(name) for name in ("ompl", "numpy", "h5py")}
    return {"by": {"apc": __version__, **versions}, "settings": asdict(settings), "result": summary}
