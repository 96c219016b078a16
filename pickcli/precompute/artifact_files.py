"""Building a cell's files and writing them."""

from __future__ import annotations

import importlib.metadata
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from pickcli import __version__
from pickcli.cell.cell import Cell
from pickcli.cell.cell_diff import parts_of
from pickcli.jobs.job_run import Build, RunOptions
from pickcli.path_planning.sampling_planner import check_installed
from pickcli.precompute.coarse_motion_job import CoarseMotionJob
from pickcli.precompute.database_builder import TrajectoryReport, build_trajectories
from pickcli.precompute.provenance import configurations_digest
from pickcli.precompute.roadmap_builder import RoadmapReport, build_roadmap
from pickcli.precompute.roadmap_edge_job import RoadmapEdgeJob
from pickcli.precompute.roadmap_settings import RoadmapSettings
from pickcli.roadmap.store import write_database, write_roadmap
from pickcli.trajopt.trajectory_settings import TrajectorySettings


def make_roadmap(
    cell: Cell,
    path: Path,
    settings: RoadmapSettings | None = None,
    run_options: RunOptions | None = None,
    overwrite: bool = True,
) -> RoadmapReport:
    """Build a cell's roadmap and write it. The same cell and settings give the same bytes.

    Until the file is written, finished tasks are kept in a journal beside it (see ``Journal``), from which an
    interrupted build continues.

    Args:
        cell: The cell.
        path: The file.
        settings: Build settings; None for the default.
        run_options: Executor of the tasks and observer of their progress; None for this process,
            unobserved.
        overwrite: Whether a file that exists by then may be replaced.

    Returns:
        Gaps of the build, and edges added besides the k nearest.

    Raises:
        InputError: The file cannot be written, no configuration is free, or the planner is not installed.
    """
    check_installed((settings or RoadmapSettings()).planner)
    job = RoadmapEdgeJob(cell, settings or RoadmapSettings())
    build = Build(job, replace(run_options or RunOptions(), output=path))
    roadmap, report = build_roadmap(job, build)
    made = _provenance(job, report.summary())
    write_roadmap(path, roadmap, cell.fingerprint, made, report.gaps, overwrite)
    build.finish()
    return report


def make_trajectories(
    cell: Cell,
    path: Path,
    settings: TrajectorySettings | None = None,
    run_options: RunOptions | None = None,
    overwrite: bool = True,
) -> TrajectoryReport:
    """Build a cell's trajectory database and write it. The same cell and settings give the same bytes.

    An interrupted build continues from its journal, like that of ``make_roadmap``.

    Args:
        cell: The cell.
        path: The file.
        settings: Build settings; None for the default.
        run_options: Executor of the tasks and observer of their progress; None for this process,
            unobserved.
        overwrite: Whether a file that exists by then may be replaced.

    Returns:
        Missing motions, and the quality of the others.

    Raises:
        InputError: The file cannot be written, or the planner is not installed.
    """
    check_installed((settings or TrajectorySettings()).planner)
    job = CoarseMotionJob(cell, settings or TrajectorySettings())
    build = Build(job, replace(run_options or RunOptions(), output=path))
    database, report = build_trajectories(job, build)
    made = _provenance(job, report.summary())
    write_database(path, database, cell.fingerprint, made, report.missing, overwrite)
    build.finish()
    return report


def versions() -> dict[str, str]:
    """Return the versions that, besides cell and settings, determine the bytes of a file.

    Returns:
        Versions of this package and of its libraries, by name; "none" of one that is not installed.
    """
    return {"apc": __version__, **{name: _version(name) for name in ("ompl", "numpy", "h5py")}}


def _version(library: str) -> str:
    try:
        return importlib.metadata.version(library)
    except importlib.metadata.PackageNotFoundError:
        return "none"


def _provenance(job: CoarseMotionJob | RoadmapEdgeJob, summary: dict[str, Any]) -> dict[str, Any]:
    """Return the provenance of a file: no times, no places, so that equal builds are equal bytes."""
    return {
        "by": versions(),
        "settings": asdict(job.settings),
        "configurations": configurations_digest(job.cell),
        "parts": parts_of(job.cell),
        "result": summary,
    }
