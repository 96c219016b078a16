"""Making a damaged file whole again: what is intact in it is kept, only what is lost is computed again."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from pickcli.cell.model import Cell
from pickcli.errors import StaleError
from pickcli.precompute.build import Means, Progress
from pickcli.precompute.coarse_motion import TrajectorySettings
from pickcli.precompute.edge_recipe import RoadmapSettings
from pickcli.precompute.make import make_roadmap, make_trajectories, versions
from pickcli.precompute.motion_recipe import record_of, task_key
from pickcli.precompute.recipe import Key, configurations_digest
from pickcli.precompute.record import Record
from pickcli.roadmap.hdf5_read import stored_file
from pickcli.roadmap.hdf5_survey import Survey
from pickcli.roadmap.planners import PlannerName
from pickcli.roadmap.stored_database import DATABASE, missing_row, motion_of
from pickcli.roadmap.stored_marks import row_mark
from pickcli.roadmap.stored_reasons import reason_row


@dataclass(frozen=True)
class Repair:
    """What a repair did.

    n_kept: tasks whose results were intact
    n_done: tasks that were done again
    is_same: whether the file now is what it was when it was made, to the byte
    """

    n_kept: int
    n_done: int
    is_same: bool


def repair(path: Path, found: Survey, cell: Cell, means: Means | None = None) -> Repair:
    """Write a damaged file anew, as the build that made it would, computing only what is lost.

    found: by surveying the same file
    Raises StaleError where that cannot give the same file: another cell, other named configurations, or
    other versions.
    """
    _check(path, found, cell)
    kept = _motions(found) if found.kind is DATABASE else _edges(found, cell)
    counted, means = _counting(replace(means or Means(), kept=kept))
    try:
        settings = _settings(found)
    except (TypeError, ValueError, KeyError) as error:
        raise StaleError(
            f"{path}: its settings are not those of this version ({error}); build it again"
        ) from None
    if isinstance(settings, TrajectorySettings):
        make_trajectories(cell, path, settings, means)
    else:
        make_roadmap(cell, path, settings, means)
    with stored_file(path, found.kind) as file:
        return Repair(counted["kept"], counted["done"], file.seal == found.seal)


def _check(path: Path, found: Survey, cell: Cell) -> None:
    """Raise StaleError where the program or the cell would not make the same file."""
    made = found.made
    for what, then, now in (
        ("a cell with fingerprint", found.fingerprint, cell.fingerprint),
        ("named configurations with SHA-256", made.get("configurations"), configurations_digest(cell)),
        ("versions", made.get("by"), versions()),
    ):
        if then != now:
            raise StaleError(
                f"{path}: was made for {what} {then}, in use: {now}; it cannot be repaired, build it again"
            )


def _settings(found: Survey) -> TrajectorySettings | RoadmapSettings:
    stored = dict(found.made["settings"])
    stored["planner"] = PlannerName(stored["planner"])
    return TrajectorySettings(**stored) if found.kind is DATABASE else RoadmapSettings(**stored)


def _motions(found: Survey) -> dict[Key, Record]:
    """Records of the motions and reasons that are intact."""
    names, motions = found.joint_names, found.intact["motions"]
    made = [motion_of(names, m.row, m.pieces["waypoints"], m.pieces["points"]) for m in motions]
    missing = [missing_row(entry.row) for entry in found.intact["missing"]]
    kept = {task_key(motion.key): record_of(motion) for motion in made}
    return kept | {task_key(key): record_of(reason) for key, reason in missing}


def _edges(found: Survey, cell: Cell) -> dict[Key, Record]:
    """The same of a roadmap. An edge is known by the configurations at its ends, whatever became of nodes."""
    configurations = {name: named.q.tobytes() for name, named in cell.configurations.items()}
    counts = Counter(configurations.values())
    name_of = {q: name for name, q in configurations.items() if counts[q] == 1}
    kept: dict[Key, Record] = {}
    for edge in found.intact["edges"]:
        waypoints = edge.pieces["waypoints"]
        ends = [name_of.get(q.tobytes()) for q in waypoints[[0, -1]]]
        if ends[0] is not None and ends[1] is not None:
            kept[ends[0], ends[1]] = Record(asdict(row_mark(edge.row)), {"waypoints": waypoints})
    reasons = (reason_row(("start", "goal"), entry.row) for entry in found.intact["missing"])
    return kept | {(min(pair), max(pair)): Record(reason=reason) for pair, reason in reasons}


def _counting(means: Means) -> tuple[dict[str, int], Means]:
    """Means that also count the tasks that were kept and those that were done."""
    counted = {"kept": 0, "done": 0}

    def report(progress: Progress) -> None:
        counted.update(kept=progress.n_kept, done=progress.n_done - progress.n_kept)
        if means.report is not None:
            means.report(progress)

    return counted, replace(means, report=report)
