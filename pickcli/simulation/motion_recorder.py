"""Recording of everything that moves in a world, to be replayed: joints, items, the vacuum in the cup."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from pickcli.geometry import Array, to_quaternion
from pickcli.motion.plan import Plan

if TYPE_CHECKING:
    from pickcli.progress import Progress
    from pickcli.simulation.world import World

LOOK_TIME = 0.02  # s of simulated time between two looks
ITEM_LOOKS = 2  # looks between two at items that are not held
SEEN_MOVE = 2e-4  # m or element of a rotation matrix, less is not recorded as a move


@dataclass(eq=False)
class RecordedRun:
    """When a plan was carried out, and how its time passed.

    Attributes:
        plan: The plan; None where the tool only let go.
        t_start: s, simulated.
        t_end: s, simulated.
        clock: Pairs of s simulated and s of the plan, rising.
    """

    plan: Plan | None
    t_start: float
    t_end: float = 0.0
    clock: list[tuple[float, float]] = field(default_factory=list)

    def note(self, world: World, progress: Progress) -> None:
        """Note how far the plan is.

        Args:
            world: The world.
            progress: s of the plan that have passed.
        """
        self.clock.append((world.t, progress.done))

    def plan_time(self, t: Array) -> Array:
        """The time of the plan at simulated times, straight between what was noted.

        Args:
            t: (N,) s, simulated.

        Returns:
            (N,) s of the plan.
        """
        knots = np.array([(self.t_start, 0.0), *self.clock])
        return np.asarray(np.interp(t, knots[:, 0], knots[:, 1]))

    def simulated_time(self, t_plan: float) -> float:
        """When the plan was at a time for the first time.

        Args:
            t_plan: s of the plan.

        Returns:
            s, simulated; the end for what was not reached.
        """
        before = (self.t_start, 0.0)
        for t, reached in self.clock:
            if reached >= t_plan and reached > before[1]:
                return before[0] + (t - before[0]) * (t_plan - before[1]) / (reached - before[1])
            before = (t, reached) if reached > before[1] else (t, before[1])
        left = t_plan - before[1]
        return min(before[0] + left, self.t_end)


class MotionRecorder:
    """Looks at a world after its steps, and keeps what it sees.

    Attributes:
        times: s of every look.
        joints: Positions (m,) of all joints at each.
        vacuum: Pa below ambient in the cup at each; 0 without a cup.
        items: By id, rows of s, position in m and quaternion x, y, z, w; only while an item moves.
        runs: What was carried out, in the order of time.
    """

    def __init__(self) -> None:
        self.times: list[float] = []
        self.joints: list[Array] = []
        self.vacuum: list[float] = []
        self.items: dict[str, list[Array]] = {}
        self.runs: list[RecordedRun] = []
        self._kept: dict[str, Array] = {}  # the last pose of each item that was kept
        self._still: dict[str, tuple[float, Array]] = {}  # s and pose when it was seen there last
        self._n_looks = 0

    def look(self, world: World) -> None:
        """Note where everything is now, if a look is due.

        Args:
            world: The world, after a step.
        """
        if self.times and world.t < self.times[-1] + LOOK_TIME - 1e-9:
            return
        self.times.append(world.t)
        self.joints.append(world.joints.copy())
        self.vacuum.append(world.tool.pressure)
        is_due, held = self._n_looks % ITEM_LOOKS == 0, world.held
        for placed in world.scene.items:
            if is_due or placed.id == held:
                self._note(placed.id, world.t, world.engine.pose(placed.id))
        self._n_looks += 1

    def begin(self, plan: Plan | None, world: World) -> RecordedRun:
        """Note that something is carried out from now on.

        Args:
            plan: The plan; None where the tool only lets go.
            world: The world.

        Returns:
            What is noted of it, to be ended.
        """
        run = RecordedRun(plan, world.t, world.t)
        self.runs.append(run)
        return run

    def _note(self, item: str, t: float, T: Array) -> None:
        """Keep the pose of an item that moved, with the last at which it still stood."""
        if item in self._kept and np.abs(T - self._kept[item]).max() < SEEN_MOVE:
            self._still[item] = (t, T)
            return
        rows, self._kept[item] = self.items.setdefault(item, []), T
        for when, pose in ([self._still.pop(item)] if item in self._still else []) + [(t, T)]:
            row = np.array([when, *pose[:3, 3], *to_quaternion(pose[:3, :3])])
            rows.append(_nearest_turn(row, rows[-1]) if rows else row)


def _nearest_turn(row: Array, before: Array) -> Array:
    """A row with that of both quaternions of its turn that is nearer to the row before."""
    if row[4:] @ before[4:] < 0.0:
        row = row.copy()
        row[4:] *= -1.0
    return row
