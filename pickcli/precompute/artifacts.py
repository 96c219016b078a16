"""The precomputed files of a cell: where they lie, how they are made, and making what is missing."""

from __future__ import annotations

import importlib.metadata
import os
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from pickcli import __version__
from pickcli.cell.model import Cell
from pickcli.errors import ArtifactError, InputError
from pickcli.precompute.build import Build, Means, Report
from pickcli.precompute.build_roadmap import RoadmapReport, build_roadmap
from pickcli.precompute.build_trajectories import TrajectoryReport, build_trajectories
from pickcli.precompute.coarse_motion import TrajectorySettings
from pickcli.precompute.edge_recipe import EdgeRecipe, RoadmapSettings
from pickcli.precompute.motion_recipe import MotionRecipe
from pickcli.precompute.recipe import configurations_digest
from pickcli.precompute.runner import Here, Runner
from pickcli.roadmap.store import how_made, read_database, read_roadmap, write_database, write_roadmap


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
    cell: Cell, path: Path, settings: RoadmapSettings | None = None, means: Means | None = None
) -> RoadmapReport:
    """Build a cell's roadmap and write it. Same cell and settings, same bytes.

    Until the file is written, finished tasks are kept in a journal beside it (see ``Journal``); an
    interrupted build goes on from there.
    """
    recipe = EdgeRecipe(cell, settings or RoadmapSettings())
    build = Build(recipe, replace(means or Means(), output=path))
    roadmap, report = build_roadmap(recipe, build)
    write_roadmap(path, roadmap, cell.fingerprint, _made(recipe, report.summary()), report.gaps)
    build.finish()
    return report


def make_trajectories(
    cell: Cell, path: Path, settings: TrajectorySettings | None = None, means: Means | None = None
) -> TrajectoryReport:
    """Build a cell's trajectory database and write it, like ``make_roadmap``."""
    recipe = MotionRecipe(cell, settings or TrajectorySettings())
    build = Build(recipe, replace(means or Means(), output=path))
    database, report = build_trajectories(recipe, build)
    write_database(path, database, cell.fingerprint, _made(recipe, report.summary()), report.missing)
    build.finish()
    return report


def ensure_artifacts(
    cell: Cell, report: Callable[[str], Report] | None = None, runner: Runner | None = None
) -> Artifacts:
    """The cell's files in the cache; what is missing, damaged or stale is built with default settings.

    report: called with what is about to be built, gives the callback for that build
    Raises InputError if the cache cannot be written.
    """
    paths = default_paths(cell)
    _make_folder(paths.roadmap.parent)
    for what, read, make, path in (
        ("roadmap", read_roadmap, make_roadmap, paths.roadmap),
        ("trajectories", read_database, make_trajectories, paths.trajectories),
    ):
        if not _is_usable(read, path, cell):
            make(cell, path, means=Means(runner or Here(), report=report and report(what)))
    return paths


def _is_usable(read: Callable[[Path, Cell], Any], path: Path, cell: Cell) -> bool:
    """Whether a file can be read and was made for these named configurations."""
    try:
        read(path, cell)
        return bool(how_made(path).get("configurations") == configurations_digest(cell))
    except (ArtifactError, InputError):
        return False


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"{folder}: cannot be made: {error.strerror}; set XDG_CACHE_HOME elsewhere"
        ) from None


def _made(recipe: MotionRecipe | EdgeRecipe, summary: dict[str, Any]) -> dict[str, Any]:
    """How a file was made: no times, no places, so that equal builds are equal bytes."""
    versions = {name: importlib.metadata.version(name) for name in ("ompl", "numpy", "h5py")}
    return {
        "by": {"apc": __version__, **versions},
        "settings": asdict(recipe.settings),
        "configurations": configurations_digest(recipe.cell),
        "result": summary,
    }
