"""Builder of the trajectory database: timed coarse motions between named configurations, after Delft.

Delft computed theirs by RRT-Connect, stored them, and replayed them between the arm's stops (section 1).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pickcli.errors import Reason
from pickcli.jobs.job_run import Build, BuildProgress
from pickcli.precompute.coarse_motion_job import CoarseMotionJob, made_of, task_key
from pickcli.precompute.motion_pairs import coarse_pairs
from pickcli.roadmap.database_tables import Missing
from pickcli.roadmap.trajectory_database import CoarseMotion, TrajectoryDatabase
from pickcli.trajopt.trajectory_settings import TrajectorySettings


@dataclass(frozen=True)
class TrajectoryReport:
    """Gaps of a build, and the quality of the motions.

    Attributes:
        settings: Settings of the motions.
        missing: Motions that were not found, with the reason: an end that is not free, or no path.
        duration: s, sum over the stored motions.
        lower_bound: s, sum of the lower bounds of the stored motions.
        progress: Final progress of the build: numbers of tasks kept from before, and done.
    """

    settings: TrajectorySettings
    missing: tuple[Missing, ...]
    duration: float
    lower_bound: float
    progress: BuildProgress

    def summary(self) -> dict[str, Any]:
        """Summarise the report.

        Returns:
            The figures as JSON values, to the ms.
        """
        return {
            "duration_s": round(self.duration, 3),
            "lower_bound_s": round(self.lower_bound, 3),
            "n_missing": len(self.missing),
        }


def build_trajectories(
    job: CoarseMotionJob, build: Build | None = None
) -> tuple[TrajectoryDatabase, TrajectoryReport]:
    """Build the database of a cell.

    Every motion is proven with the cell's clearance and timed within its limits.

    Args:
        job: The job that makes motions.
        build: Build of that job, with a journal or workers; None for this process.

    Returns:
        The database, and a report with its gaps.
    """
    keys = coarse_pairs(job.cell)
    build = build or Build(job)
    records = build.records([task_key(key) for key in keys])
    names = job.cell.robot.joint_names
    made = [(key, made_of(key, record, names)) for key, record in zip(keys, records, strict=True)]
    motions = [motion for _, motion in made if isinstance(motion, CoarseMotion)]
    missing = tuple((key, reason) for key, reason in made if isinstance(reason, Reason))
    database = TrajectoryDatabase.of(names, motions)
    duration, bound = float(database.durations.sum()), float(database.lower_bounds.sum())
    return database, TrajectoryReport(job.settings, missing, duration, bound, build.progress)
