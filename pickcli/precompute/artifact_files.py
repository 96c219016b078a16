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
    """Build a cell's roadmap and write it. Same cell and settings, same bytes.

    Until the file is written, finished tasks are kept in a journal beside it (see ``Journal``); an
    interrupted build goes on from there.

    Args:
        cell: The cell.
        path: Where to write.
        settings: How to build; None for the default.
        run_options: Executor of the tasks and observer of their progress; None for this process,
            unobserved.
        overwrite: Whether a file that is there by then may be replaced.

    Returns:
        What the build could not do, and what it did beyond the k nearest.

    Raises:
        InputError: The place cannot be written, or not one configuration is free.
    """
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
    """Build a cell's trajectory database and write it. Same cell and settings, same bytes.

    An interrupted build goes on from its journal, as that of ``make_roadmap``.

    Args:
        cell: The cell.
        path: Where to write.
        settings: How to build; None for the default.
        run_options: Executor of the tasks and observer of their progress; None for this process,
            unobserved.
        overwrite: Whether a file that is there by then may be replaced.

    Returns:
        What the build could not do, and how good the rest is.

    Raises:
        InputError: The place cannot be written.
    """
    job = CoarseMotionJob(cell, settings or TrajectorySettings())
    build = Build(job, replace(run_options or RunOptions(), output=path))
    database, report = build_trajectories(job, build)
    made = _provenance(job, report.summary())
    write_database(path, database, cell.fingerprint, made, report.missing, overwrite)
    build.finish()
    return report


def versions() -> dict[str, str]:
    """Tell what decides about the bytes of a file besides cell and settings.

    Returns:
        Our version and those of the libraries, by name.
    """
    libraries = ("ompl", "numpy", "h5py")
    return {"apc": __version__, **{name: importlib.metadata.version(name) for name in libraries}}


def _provenance(job: CoarseMotionJob | RoadmapEdgeJob, summary: dict[str, Any]) -> dict[str, Any]:
    """How a file was made: no times, no places, so that equal builds are equal bytes."""
    return {
        "by": versions(),
        "settings": asdict(job.settings),
        "configurations": configurations_digest(job.cell),
        "parts": parts_of(job.cell),
        "result": summary,
    }
