"""Refresh of a file after a change of its cell; results that the change does not affect are kept.

A refresh finds motions or edges for the same pairs as a build from scratch and, if a solid was removed,
proves the same pairs for all pod poses. Kept results are not optimised again. So after a removal, a build
from scratch may find faster paths; a result for all pod poses is kept, where a build might prefer a faster
one for the nominal pod pose; and after a part of the pod moved, a build may find paths for all pod poses that
are missed here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.cell_diff import CellChange, change_since
from pickcli.cell.pod_tolerance import PodPoses
from pickcli.cell.tool import MOVING, ToolState
from pickcli.errors import Reason
from pickcli.jobs.job import Key
from pickcli.jobs.job_result import JobResult
from pickcli.jobs.job_run import RunOptions
from pickcli.precompute.artifact_files import versions
from pickcli.precompute.coarse_motion_job import made_of, motion_key, record_of
from pickcli.precompute.provenance import configurations_digest
from pickcli.precompute.recovered_results import make_again, stored_records
from pickcli.precompute.revalidation import Revalidation
from pickcli.precompute.roadmap_edge_job import validity_of
from pickcli.roadmap.database_tables import DATABASE
from pickcli.roadmap.trajectory_database import CoarseMotion, PayloadClass
from pickcli.storage.integrity_scan import IntegrityReport


@dataclass(frozen=True)
class Refresh:
    """Result of a refresh.

    Attributes:
        changed: Solids that changed.
        why_rebuilt: Why nothing could be kept, "" if something was.
        n_stored: Number of motions or edges in the file.
        n_proven: Number of these that the change affected, so that they were proven again.
        n_kept: Number of tasks whose results were kept, unchanged or proven again.
        n_planned: Number of tasks that were done again.
    """

    changed: tuple[str, ...]
    why_rebuilt: str
    n_stored: int
    n_proven: int
    n_kept: int
    n_planned: int


def refresh(path: Path, found: IntegrityReport, cell: Cell, run_options: RunOptions | None = None) -> Refresh:
    """Write a roadmap or database again for its changed cell.

    The old file stays until the new one is complete, and finished tasks are kept in a journal, as in a build.

    Args:
        path: The file.
        found: Result of ``surveyed`` for the same file; damaged parts are computed again.
        cell: The changed cell.
        run_options: Executor of the tasks and observer of their progress; None for this process, unobserved.

    Returns:
        Result, with what was kept and what was computed.

    Raises:
        StaleError: This version does not have the settings of the file.
    """
    stored = stored_records(found, cell)
    n_stored = sum(record.reason is None for record in stored.values())
    change = _change(found, cell)
    why = _why_rebuilt(found, change)
    are_ends_same = found.made.get("configurations") == configurations_digest(cell)
    sieve = None if why or change is None else _Sieve(cell, change, stored, are_ends_same)
    kept = {} if sieve is None else sieve.motions() if found.kind is DATABASE else sieve.edges()
    n_kept, n_planned = make_again(path, found, cell, replace(run_options or RunOptions(), kept=kept))
    n_proven = 0 if sieve is None else len(sieve.touched)
    return Refresh(() if change is None else change.solids, why, n_stored, n_proven, n_kept, n_planned)


def _change(found: IntegrityReport, cell: Cell) -> CellChange | None:
    """Return the change since the file was made, or None if the file does not state its cell."""
    try:
        return change_since(found.made["parts"], cell)
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError):
        return None


def _why_rebuilt(found: IntegrityReport, change: CellChange | None) -> str:
    """Explain why nothing of a file can be kept, "" if something can."""
    if change is None:
        return "the file does not say what its cell was"
    if found.made.get("by") != versions():
        return f"it was made by other versions: {found.made.get('by')}, in use: {versions()}"
    return f"not as it was: {', '.join(change.rules)}" if change.rules else ""


@dataclass
class _Sieve:
    """Selects the results that still hold.

    are_ends_same: whether the named configurations are unchanged
    touched: motions or edges that had to be proven again
    """

    cell: Cell
    change: CellChange
    stored: Mapping[Key, JobResult]
    are_ends_same: bool
    touched: list[Key] = field(default_factory=list)
    proof: Revalidation = field(init=False)

    def __post_init__(self) -> None:
        self.proof = Revalidation(self.cell, self.change)

    def motions(self) -> dict[Key, JobResult]:
        """Return the motions and reasons that hold in the changed cell."""
        kept: dict[Key, JobResult] = {}
        for key, record in self.stored.items():
            made = made_of(motion_key(key), record, self.cell.robot.joint_names)
            still = self._still_missing(made) if isinstance(made, Reason) else self._motion(key, made)
            if still is not None:
                kept[key] = record if still is made else record_of(still)
        return kept

    def edges(self) -> dict[Key, JobResult]:
        """Return the edges and reasons that hold in the changed cell."""
        return {
            key: record
            for key, record in self.stored.items()
            if (self._still_missing(record.reason) if record.reason else self._edge_holds(key, record))
        }

    def _still_missing(self, reason: Reason) -> Reason | None:
        """Return a reason, unless a solid was removed that may have caused it."""
        return reason if self.are_ends_same and not self.change.removed else None

    def _motion(self, key: Key, motion: CoarseMotion) -> CoarseMotion | None:
        """Return a motion, with its new clearance if it is affected; None if it must be planned again."""
        tool_state = self._tool_state(key)
        if tool_state is None or not self._has_ends(motion, tool_state):
            return None
        if motion.validity.pod_poses is PodPoses.NOMINAL and self.proof.is_worth_replanning(
            motion.path.waypoints, tool_state, motion.key.payload
        ):
            return None
        if self.proof.is_motion_untouched(motion):
            return motion
        self.touched.append(key)
        return self.proof.proven_motion(motion)

    def _edge_holds(self, key: Key, record: JobResult) -> bool:
        """Whether an edge holds. Its key was derived from its end configurations, so these are unchanged."""
        pod_poses, waypoints = validity_of(record).pod_poses, record.arrays["waypoints"]
        if pod_poses is PodPoses.NOMINAL and self.proof.is_worth_replanning(
            waypoints, MOVING, PayloadClass.EMPTY
        ):
            return False
        if self.proof.is_edge_untouched(waypoints, pod_poses):
            return True
        self.touched.append(key)
        return self.proof.is_edge_proven(waypoints, pod_poses)

    def _tool_state(self, key: Key) -> ToolState | None:
        """Return the narrowest tool state for a motion between two names; None if a name no longer exists."""
        if not all(name in self.cell.configurations for name in key[:2]):
            return None
        tool_states = {self.cell.configurations[name].tool_state for name in key[:2]}
        return tool_states.pop() if len(tool_states) == 1 else MOVING

    def _has_ends(self, motion: CoarseMotion, tool_state: ToolState) -> bool:
        """Whether a motion leads between the current configurations of its names."""
        if motion.tool_state not in (tool_state, MOVING):
            return False
        ends = [self.cell.configurations[name].q for name in (motion.key.start, motion.key.goal)]
        return bool(np.array_equal(motion.path.waypoints[[0, -1]], ends))
