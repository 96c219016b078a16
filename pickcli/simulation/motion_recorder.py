"""Records all motion in a world for replay: joints, items, and the vacuum in the cup."""

from __future__ import annotations

from bisect import bisect_left
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

import numpy as np

from pickcli.cell.robot import Robot
from pickcli.cell.tool import ToolState
from pickcli.geometry import Array, to_quaternion
from pickcli.motion.plan import Plan

if TYPE_CHECKING:
    from pickcli.cell.robot import Robot
    from pickcli.progress import Progress
    from pickcli.scene.scene import Scene
    from pickcli.simulation.engine import Engine
    from pickcli.simulation.simulated_tool import SimulatedTool
    from pickcli.simulation.world import World

LOOK_TIME = 0.02  # s of simulated time between samples
ITEM_LOOKS = 2  # every how many samples items that are not held are recorded
SAME_TIME = 1e-6  # s
SEEN_MOVE = 2e-4  # m or element of a rotation matrix; smaller changes are not recorded


class RecordedWorld(Protocol):
    """A world that can be recorded.

    Attributes:
        scene: The scene, whose items are in the engine by their ids.
        engine: The engine.
        tool: The simulated tool.
    """

    scene: Scene
    engine: Engine
    tool: SimulatedTool

    @property
    def t(self) -> float:
        """Time (s) since the start."""

    @property
    def robot(self) -> Robot:
        """The arm that moves."""

    @property
    def joints(self) -> Array:
        """(m,) positions of its moving joints."""

    @property
    def held(self) -> str | None:
        """Id of the held item, if the tool knows it."""


@dataclass(frozen=True, eq=False)
class _Sample:
    """A sample of all arms: s, joints (m,) in rad or m, and Pa of vacuum."""

    t: float
    joints: Array
    vacuum: float


@dataclass(eq=False)
class RecordedRun:
    """Execution of a plan, with the relation of its time to simulated time.

    Attributes:
        plan: The plan; None if the tool only released.
        arm: Name of the arm that moved; empty in a cell with one arm.
        t_start: s, simulated.
        t_end: s, simulated.
        clock: Pairs of simulated time and plan time, s, increasing.
        t_world: s, simulated, at which its world began.
    """

    plan: Plan | None
    arm: str
    t_start: float
    t_end: float = 0.0
    clock: list[tuple[float, float]] = field(default_factory=list)
    t_world: float = 0.0

    def note(self, world: RecordedWorld, progress: Progress) -> None:
        """Record the progress of the plan.

        Args:
            world: The world.
            progress: Progress in s of the plan.
        """
        self.clock.append((self.t_world + world.t, progress.done))

    def plan_time(self, t: Array) -> Array:
        """Interpolate the plan's time at simulated times.

        Args:
            t: (N,) s, simulated.

        Returns:
            (N,) s of the plan.
        """
        knots = np.array([(self.t_start, 0.0), *self.clock])
        return np.asarray(np.interp(t, knots[:, 0], knots[:, 1]))

    def simulated_time(self, t_plan: float) -> float:
        """Compute when the plan first reached a time.

        Args:
            t_plan: s of the plan.

        Returns:
            s, simulated; the end if it was not reached.
        """
        before = (self.t_start, 0.0)
        for t, reached in self.clock:
            if reached >= t_plan and reached > before[1]:
                return before[0] + (t - before[0]) * (t_plan - before[1]) / (reached - before[1])
            before = (t, reached) if reached > before[1] else (t, before[1])
        left = t_plan - before[1]
        return min(before[0] + left, self.t_end)


class MotionRecorder:
    """Samples a world after its steps, and keeps the samples.

    Args:
        start: Positions in rad or m by joint of all arms at the start; None for a single arm, whose joints
            are read from the world.

    Attributes:
        joint_names: Names of the m joints.
        times: s of every sample.
        joints: Positions (m,) of all joints in each sample; an arm that does not move keeps its last ones.
        vacuum: Pa below ambient in the cup in each sample, of several the most; 0 without a cup.
        items: By id, rows of s, position in m and quaternion x, y, z, w; only while an item moves.
        runs: Executions, in order of time.
        t_world: s at which the world began that is recorded.
    """

    def __init__(self, start: Mapping[str, float] | None = None) -> None:
        self._positions = dict(start or {})
        self.times: list[float] = []
        self.joints: list[Array] = []
        self.vacuum: list[float] = []
        self.items: dict[str, list[Array]] = {}
        self.runs: list[RecordedRun] = []
        self._kept: dict[str, Array] = {}  # the last recorded pose of each item
        self._still: dict[str, tuple[float, Array]] = {}  # s and pose of the last sample at rest
        self._n_looks = 0
        self.t_world = 0.0
        self._meanwhile: deque[_Sample] = deque()  # later samples, in which other arms move
        self._passed: _Sample | None = None  # the last of them that is past
        self._mine = np.zeros(0, dtype=np.intp)  # columns of the arm that is recorded

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, in the order of their columns."""
        return tuple(self._positions)

    def snapshot(self) -> MotionRecorder:
        """Return a copy of what was recorded so far, which does not grow."""
        copy = MotionRecorder(self._positions)
        copy.times, copy.joints, copy.vacuum = list(self.times), list(self.joints), list(self.vacuum)
        copy.items = {name: list(rows) for name, rows in self.items.items()}
        copy.runs = list(self.runs)
        return copy

    def enter(self, world: World, t: float) -> None:
        """Go on with another world, in place of what the ones before showed of later times.

        Items that are not in it, and arms that do not move in it, are where those before have them.

        Args:
            world: The world, which begins.
            t: s at which it does, not before the beginning of the last one.
        """
        self.finish()
        self.t_world = t
        columns = {name: k for k, name in enumerate(self._positions)}
        mine = [columns[name] for name in world.robot.moving_joints if name in columns]
        self._mine = np.array(mine, dtype=np.intp)
        n, self._passed = bisect_left(self.times, t), None
        if len(mine) < len(columns):  # there are other arms
            later = zip(self.times[n:], self.joints[n:], self.vacuum[n:], strict=True)
            self._meanwhile.extend(_Sample(*each) for each in later)
            if n > 0:
                self._passed = _Sample(self.times[n - 1], self.joints[n - 1], self.vacuum[n - 1])
        del self.times[n:], self.joints[n:], self.vacuum[n:]
        if self.joints:
            self._positions = dict(zip(self._positions, self.joints[-1].tolist(), strict=True))
        for placed in world.scene.items:
            rows = self.items.get(placed.id, [])
            del rows[bisect_left(rows, t, key=lambda row: float(row[0])) :]
            self._kept.pop(placed.id, None)
            self._still.pop(placed.id, None)
        self.look(world)
        world.observer = self.look

    def look(self, world: RecordedWorld) -> None:
        """Record the current state if a sample is due.

        Args:
            world: The world, after a step.
        """
        t = self.t_world + world.t
        if self.times and t < self.times[-1] + LOOK_TIME - 1e-9:
            return
        self.times.append(t)
        self._let_others_move(t)
        self._positions |= dict(zip(world.robot.moving_joints, world.joints.tolist(), strict=True))
        self.joints.append(np.array(list(self._positions.values())))
        self.vacuum.append(max(world.tool.pressure, self._others_vacuum))
        is_due, held = self._n_looks % ITEM_LOOKS == 0, world.held
        for placed in world.scene.items:
            if is_due or placed.id == held:
                self._note(placed.id, t, world.engine.pose(placed.id))
        self._n_looks += 1

    def finish(self) -> None:
        """Let the arms of earlier worlds move on after the end of the last one."""
        here = np.array(list(self._positions.values()))[self._mine] if len(self._mine) else np.zeros(0)
        while self._meanwhile:
            each = self._meanwhile.popleft()
            if self.times and each.t <= self.times[-1] + SAME_TIME:
                continue
            row = each.joints.copy()
            row[self._mine] = here
            self.times.append(each.t)
            self.joints.append(row)
            self.vacuum.append(each.vacuum)

    def _let_others_move(self, t: float) -> None:
        """Move the other arms on to a time (s), between their samples before and after it."""
        while self._meanwhile and self._meanwhile[0].t <= t:
            self._passed = self._meanwhile.popleft()
        if (before := self._passed) is None:
            return
        after = self._meanwhile[0] if self._meanwhile else before
        share = (t - before.t) / (after.t - before.t) if after.t > before.t else 0.0
        row = before.joints + share * (after.joints - before.joints)
        row[self._mine] = np.array(list(self._positions.values()))[self._mine]
        self._positions = dict(zip(self._positions, row.tolist(), strict=True))

    @property
    def _others_vacuum(self) -> float:
        """Vacuum (Pa below ambient) in the cups of other arms that move."""
        return self._passed.vacuum if self._passed is not None and self._meanwhile else 0.0

    def begin(self, plan: Plan | None, world: RecordedWorld) -> RecordedRun:
        """Record the beginning of an execution.

        Args:
            plan: The plan; None if the tool only releases.
            world: The world.

        Returns:
            The execution, whose end is to be set.
        """
        t = self.t_world + world.t
        run = RecordedRun(plan, world.scene.cell.arm, t, t, t_world=self.t_world)
        self.runs.append(run)
        return run

    def _note(self, item: str, t: float, T: Array) -> None:
        """Record the pose of an item that moved, preceded by its last pose at rest."""
        if item in self._kept and np.abs(T - self._kept[item]).max() < SEEN_MOVE:
            self._still[item] = (t, T)
            return
        rows, self._kept[item] = self.items.setdefault(item, []), T
        for when, pose in ([self._still.pop(item)] if item in self._still else []) + [(t, T)]:
            row = np.array([when, *pose[:3, 3], *to_quaternion(pose[:3, :3])])
            rows.append(_nearest_turn(row, rows[-1]) if rows else row)


def joint_positions(robot: Robot, q: Array, tool_state: ToolState) -> dict[str, float]:
    """Return where the joints of an arm and its tool stand.

    Args:
        robot: The arm.
        q: (n,) configuration, in rad or m.
        tool_state: State of the tool.

    Returns:
        Positions in rad or m by joint.
    """
    found = dict(zip(robot.joint_names, q.tolist(), strict=True))
    return found | {name: robot.tool.joint_position(name, tool_state) for name in robot.tool.joints}


def _nearest_turn(row: Array, before: Array) -> Array:
    """The row with the sign of its quaternion that is nearer to the row before."""
    if row[4:] @ before[4:] < 0.0:
        row = row.copy()
        row[4:] *= -1.0
    return row
