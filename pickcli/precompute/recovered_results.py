"""Recovery of a file's content as the records of the build that made it."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict
from operator import index
from pathlib import Path

from pickcli.cell.cell import Cell
from pickcli.errors import StaleError
from pickcli.jobs.job import Key
from pickcli.jobs.job_result import JobResult
from pickcli.jobs.job_run import RunOptions
from pickcli.path_planning.planner_names import PlannerName
from pickcli.precompute.artifact_files import make_roadmap, make_trajectories
from pickcli.precompute.coarse_motion_job import record_of, task_key
from pickcli.precompute.database_builder import TrajectoryReport
from pickcli.precompute.experience import LEARNED
from pickcli.precompute.roadmap_builder import RoadmapReport
from pickcli.precompute.roadmap_settings import RoadmapSettings
from pickcli.roadmap.common_columns import reason_row, row_validity
from pickcli.roadmap.database_tables import DATABASE
from pickcli.roadmap.recovered_content import intact_missing, intact_motions
from pickcli.storage.integrity_scan import IntegrityReport
from pickcli.trajopt.trajectory_settings import TrajectorySettings


def stored_records(found: IntegrityReport, cell: Cell) -> dict[Key, JobResult]:
    """Convert the intact content of a database or roadmap to the records of the tasks that made it.

    Args:
        found: Result of ``surveyed``, which checks its consistency.
        cell: The cell that the records are for.

    Returns:
        Records by task; none if the file has other joints.
    """
    if found.joint_names != cell.robot.joint_names:
        return {}
    return _motions(found) if found.kind is DATABASE else _edges(found, cell)


def make_again(path: Path, found: IntegrityReport, cell: Cell, run_options: RunOptions) -> tuple[int, int]:
    """Write a file for a cell with the settings that are recorded in it.

    Args:
        path: The file.
        found: Result of ``surveyed`` for the same file.
        cell: The cell to write it for.
        run_options: Kept results, executor of the tasks, observer of progress.

    Returns:
        How many tasks were kept, and how many were done.

    Raises:
        StaleError: This version does not have the settings.
    """
    settings = _settings(path, found)
    report: TrajectoryReport | RoadmapReport
    if isinstance(settings, TrajectorySettings):
        report = make_trajectories(cell, path, settings, run_options)
    else:
        report = make_roadmap(cell, path, settings, run_options)
    return report.progress.n_kept, report.progress.n_done_now


def _settings(path: Path, found: IntegrityReport) -> TrajectorySettings | RoadmapSettings:
    try:
        stored = dict(found.made["settings"])
        if stored == LEARNED:
            raise StaleError(f"{path}: was learned, not built; delete it, and it will be learned again")
        planner = PlannerName(stored.pop("planner"))
        counts = {name: index(count) for name, count in stored.items()}
        return (TrajectorySettings if found.kind is DATABASE else RoadmapSettings)(planner, **counts)
    except (TypeError, ValueError, KeyError) as error:
        raise StaleError(
            f"{path}: its settings are not those of this version ({error}); build it again"
        ) from None


def _motions(found: IntegrityReport) -> dict[Key, JobResult]:
    """Return records of the intact motions and reasons."""
    kept = {task_key(motion.key): record_of(motion) for motion in intact_motions(found)}
    return kept | {task_key(key): record_of(reason) for key, reason in intact_missing(found)}


def _edges(found: IntegrityReport, cell: Cell) -> dict[Key, JobResult]:
    """Return records of the intact edges and reasons; the ends of its path identify an edge."""
    configurations = {name: named.q.tobytes() for name, named in cell.configurations.items()}
    counts = Counter(configurations.values())
    name_of = {q: name for name, q in configurations.items() if counts[q] == 1}
    kept: dict[Key, JobResult] = {}
    for edge in found.intact["edges"]:
        waypoints = edge.pieces["waypoints"]
        ends = [name_of.get(q.tobytes()) for q in waypoints[[0, -1]]]
        if ends[0] is not None and ends[1] is not None:
            kept[ends[0], ends[1]] = JobResult(asdict(row_validity(edge.row)), {"waypoints": waypoints})
    reasons = (reason_row(("start", "goal"), entry.row) for entry in found.intact["missing"])
    return kept | {(min(pair), max(pair)): JobResult(reason=reason) for pair, reason in reasons}
