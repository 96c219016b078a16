"""The two files that are built once per cell, as tests meet them."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from pickcli.cell.cell import Cell
from pickcli.jobs.job_run import RunOptions
from pickcli.path_planning.planner_names import PlannerName
from pickcli.precompute.artifact_files import make_roadmap, make_trajectories
from pickcli.precompute.coarse_motion_job import CoarseMotionJob
from pickcli.precompute.roadmap_edge_job import RoadmapEdgeJob
from pickcli.precompute.roadmap_settings import RoadmapSettings
from pickcli.roadmap.store import read_database, read_roadmap
from support.small_cell import LEAST_EFFORT, small_cell

FEW_EDGES = RoadmapSettings(PlannerName.RRT_CONNECT, n_neighbours=3, max_iterations=1000, seed=8)


@cache
def cell() -> Cell:
    return small_cell("home", "bin_A", "bin_E", "tote", "tote_10h")


@dataclass(frozen=True)
class StoredKind:
    """A trajectory database or a roadmap."""

    make: Callable[[Path, RunOptions | None], object]
    job: Callable[[], Any]
    content: Callable[[Path], list[Any]]  # all numbers that a user of the file is served

    @cache  # noqa: B019 (there are two of them, as long as the tests run)
    def good(self) -> bytes:
        """Of an undisturbed build."""
        with tempfile.TemporaryDirectory() as folder:
            self.make(Path(folder) / "out.h5", None)
            return (Path(folder) / "out.h5").read_bytes()

    @cache  # noqa: B019
    def good_content(self) -> list[Any]:
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "out.h5").write_bytes(self.good())
            return self.content(Path(folder) / "out.h5")


def _motions(path: Path) -> list[Any]:
    timed = [motion.trajectory for motion in read_database(path, cell(), points=True)]
    return [array for t in timed if t is not None for array in (t.times, t.positions, t.velocities)]


def _edges(path: Path) -> list[Any]:
    roadmap = read_roadmap(path, cell())
    return [roadmap.configurations, roadmap.edges, roadmap.waypoints, roadmap.offsets]


MOTIONS = StoredKind(
    lambda path, run_options: make_trajectories(cell(), path, LEAST_EFFORT, run_options),
    lambda: CoarseMotionJob(cell(), LEAST_EFFORT),
    _motions,
)
EDGES = StoredKind(
    lambda path, run_options: make_roadmap(cell(), path, FEW_EDGES, run_options),
    lambda: RoadmapEdgeJob(cell(), FEW_EDGES),
    _edges,
)
KINDS = {"motions": MOTIONS, "edges": EDGES}
