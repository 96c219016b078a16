"""Experience: new paths of queries are proven for the empty cell, and stored for later queries.

Delft's cache never computed on a miss, which they regretted. Learned edges and motions are kept in two files
beside the built ones, with the same formats, seals and checks, so that built files stay unchanged. A process
that learns locks a file, reads it, adds to it and replaces it: several processes may learn at the same time,
and a kill loses at most the current entry.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

from pickcli.cell.cell import Cell
from pickcli.errors import ArtifactError, InputError, Reason
from pickcli.files.file_lock import locked
from pickcli.geometry import Array
from pickcli.precompute.artifact_files import versions
from pickcli.precompute.coarse_motion_job import CoarseMotionJob, made_of, task_key
from pickcli.precompute.provenance import configurations_digest
from pickcli.precompute.roadmap_edge_job import RoadmapEdgeJob
from pickcli.precompute.roadmap_settings import RoadmapSettings
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.merge_edges import with_polylines, without_doubles
from pickcli.roadmap.query_experience import QueryExperience
from pickcli.roadmap.store import read_database, read_roadmap, write_database, write_roadmap
from pickcli.roadmap.trajectory_database import MotionKey, TrajectoryDatabase
from pickcli.trajopt.trajectory_settings import TrajectorySettings

T = TypeVar("T")

LEARNED = {"learned": True}  # recorded in a learned file instead of build settings

# Limits of the number of entries; the oldest are dropped.
MOST_EDGES = 400
MOST_MOTIONS = 200


@dataclass(frozen=True)
class RecordedExperience:
    """Counts of experience that was stored.

    Attributes:
        edges: Number of polylines that were stored.
        motions: Number of motions that were made and stored.
        unproven: Number of polylines that were not stored because they are not free in the empty cell with
            the cup in any state.
    """

    edges: int = 0
    motions: int = 0
    unproven: int = 0


@dataclass(frozen=True, eq=False)
class ExperienceFiles:
    """Files with the experience of one cell.

    Attributes:
        cell: The cell.
        roadmap: The learned roadmap; created with the first stored edge.
        trajectories: The learned database; created with the first stored motion.
        settings: Settings of the motions.
    """

    cell: Cell
    roadmap: Path
    trajectories: Path
    settings: TrajectorySettings = field(default_factory=TrajectorySettings)

    @classmethod
    def beside(cls, cell: Cell, roadmap: Path, trajectories: Path) -> ExperienceFiles:
        """Name the learned files beside built ones: ``roadmap.learned.h5`` beside ``roadmap.h5``.

        Args:
            cell: The cell.
            roadmap: Path of a roadmap.
            trajectories: Path of a trajectory database.

        Returns:
            The learned files, which need not exist.
        """
        return cls(cell, _beside(roadmap), _beside(trajectories))

    def edges(self) -> list[Array]:
        """Read the learned polylines.

        Returns:
            Each (K, n), the oldest first.

        Raises:
            DamagedError: The content of the file is not what was written.
            StaleError: It was made for another cell or by another version of the format.
        """
        stored = _read(self.roadmap, lambda: read_roadmap(self.roadmap, self.cell))
        return [] if stored is None else [stored.edge_path(edge) for edge in range(stored.n_edges)]

    def motions(self, points: bool = False) -> TrajectoryDatabase | None:
        """Read the learned motions.

        Args:
            points: Whether to read the timed points as well.

        Returns:
            The motions, None if there is no file yet.

        Raises:
            DamagedError: The content of the file is not what was written.
            StaleError: It was made for another cell or by another version of the format.
        """
        return _read(self.trajectories, lambda: read_database(self.trajectories, self.cell, points))

    def learn_edges(self, experience: Sequence[QueryExperience]) -> RecordedExperience:
        """Store the polylines of queries that are new and proven in the empty cell.

        Args:
            experience: Experience of queries.

        Returns:
            How many were stored, and how many were not proven.

        Raises:
            InputError: The file cannot be written.
            DamagedError: The content of the file is not what was written.
            StaleError: It was made for another cell or by another version of the format.
        """
        found = [polyline for query in experience for polyline in query.polylines]
        proven = [polyline for polyline in found if self._proof.checker.first_blocked_edge(polyline) == -1]
        if not proven:
            return RecordedExperience(unproven=len(found))
        self._make_folder(self.roadmap)
        with locked(self.roadmap):
            old = self.edges()
            fresh = without_doubles(old, proven)
            if fresh:
                self._write_edges([*old, *fresh][-MOST_EDGES:])
        return RecordedExperience(edges=len(fresh), unproven=len(found) - len(proven))

    def learn_motion(self, key: MotionKey) -> RecordedExperience:
        """Make the motion of a key, like a build, and store it if there is one.

        Args:
            key: Ends and payload class of the motion.

        Returns:
            Whether it was stored, as a count of 0 or 1 motions.

        Raises:
            InputError: The file cannot be written.
            DamagedError: The content of the file is not what was written.
            StaleError: It was made for another cell or by another version of the format.
        """
        job = CoarseMotionJob(self.cell, self.settings)
        made = made_of(key, job.make(task_key(key)), self.cell.robot.joint_names)
        if isinstance(made, Reason):
            return RecordedExperience()
        self._make_folder(self.trajectories)
        with locked(self.trajectories):
            old = self.motions(points=True)
            if old is not None and old.lookup(key.start, key.goal, key.payload) is not None:
                return RecordedExperience()
            motions = [*(old or ()), made][-MOST_MOTIONS:]
            database = TrajectoryDatabase.of(self.cell.robot.joint_names, motions)
            write_database(self.trajectories, database, self.cell.fingerprint, self._provenance)
        return RecordedExperience(motions=1)

    def missed(
        self, experience: Sequence[QueryExperience], *databases: TrajectoryDatabase | None
    ) -> list[MotionKey]:
        """List the motions between named configurations that queries needed and no database holds.

        Args:
            experience: The queries.
            *databases: Databases that were searched; None for one that does not exist.

        Returns:
            The motions, each once, in one direction, in the order of the queries.
        """
        name_of = {named.q.tobytes(): name for name, named in self.cell.configurations.items()}
        missed: list[MotionKey] = []
        for query in experience:
            start, goal = (name_of.get(q.tobytes()) for q in (query.q_start, query.q_goal))
            if start is None or goal is None or start == goal:
                continue
            key = MotionKey(start, goal, query.payload)
            is_stored = any(d and d.lookup(start, goal, query.payload) for d in databases)
            if not is_stored and key not in missed and key.reversed() not in missed:
                missed.append(key)
        return missed

    def _write_edges(self, polylines: Sequence[Array]) -> None:
        roadmap = with_polylines(Roadmap.empty(self.cell.robot.joint_names), polylines)
        write_roadmap(self.roadmap, roadmap, self.cell.fingerprint, self._provenance)

    @property
    def _provenance(self) -> dict[str, Any]:
        return {
            "by": versions(),
            "settings": LEARNED,
            "configurations": configurations_digest(self.cell),
            "result": {},
        }

    @cached_property
    def _proof(self) -> RoadmapEdgeJob:
        """The job that proves edges when a roadmap is built."""
        return RoadmapEdgeJob(self.cell, RoadmapSettings())

    @staticmethod
    def _make_folder(path: Path) -> None:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{path.parent}: cannot be made: {error.strerror}; name another place") from None


def _beside(path: Path) -> Path:
    return path.with_name(f"{path.stem}.learned{path.suffix}")


def _read(path: Path, read: Callable[[], T]) -> T | None:
    """Read a learned file; return None if it does not exist."""
    if not path.exists():
        return None
    try:
        return read()
    except ArtifactError as error:
        raise type(error)(f"{error}, or delete it: what it held will be learned again") from None
