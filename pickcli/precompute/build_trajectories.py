"""The offline half after Delft: a database of timed coarse motions between named configurations.

Delft computed theirs by RRT-Connect, kept them, and replayed them between the arm's stops (section 1).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from pickcli.cell.model import Cell
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.precompute.coarse_motion import MotionMaker, TrajectorySettings
from pickcli.precompute.pairs import coarse_pairs
from pickcli.roadmap.database import CoarseMotion, MotionKey, TrajectoryDatabase
from pickcli.roadmap.space import JointSpace

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class TrajectoryReport:
    """What a build could not do, and how good the rest is.

    failed: pairs without a motion, with the reason: an end that is not free, or no path
    duration: s, sum over the stored motions
    lower_bound: s, sum over the same of what no motion can undercut (each joint alone, without jerk limit)
    """

    settings: TrajectorySettings
    failed: tuple[tuple[MotionKey, Reason], ...]
    duration: float
    lower_bound: float

    def summary(self) -> dict[str, Any]:
        """The report as JSON values, to the ms."""
        return {
            "duration_s": round(self.duration, 3),
            "lower_bound_s": round(self.lower_bound, 3),
            "failed": [f"{key.start} to {key.goal}, {key.payload}: {reason}" for key, reason in self.failed],
        }


def build_trajectories(
    cell: Cell, settings: TrajectorySettings | None = None, progress: Progress | None = None
) -> tuple[TrajectoryDatabase, TrajectoryReport]:
    """The database of a cell, every motion proven with the cell's clearance and timed within its limits.

    Each pair's seeds follow from its names: the order of the pairs does not matter. ``progress`` gets pairs
    done, pairs in all, and the pair in work.
    """
    maker = MotionMaker(cell, settings or TrajectorySettings())
    motions: list[CoarseMotion] = []
    failed: list[tuple[MotionKey, Reason]] = []
    keys = coarse_pairs(cell)
    for done, key in enumerate(keys):
        if progress is not None:
            progress(done, len(keys), f"{key.start} to {key.goal}")
        made = maker.make(key)
        if isinstance(made, Reason):
            failed.append((key, made))
        else:
            motions.append(made)
    if progress is not None:
        progress(len(keys), len(keys), "")
    database = TrajectoryDatabase.of(cell.robot.joint_names, motions)
    space = JointSpace.of(cell.robot, cell.speed_scale)
    bound = sum(lower_bound(space, motion.path.start, motion.path.end) for motion in motions)
    duration = float(database.durations.sum())
    return database, TrajectoryReport(maker.settings, tuple(failed), duration, bound)


def lower_bound(space: JointSpace, q0: Array, q1: Array) -> float:
    """s that no motion from rest to rest can undercut: the slowest joint alone, without jerk limit."""
    distance = np.abs(q1 - q0)
    ramp = space.velocity / space.acceleration
    triangles = 2 * np.sqrt(distance / space.acceleration)
    trapezoids = distance / space.velocity + ramp
    return float(np.where(distance < space.velocity * ramp, triangles, trapezoids).max())
