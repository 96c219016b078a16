"""Recovery after a stop: brings a possibly held item to a safe place, then the arm, level by level.

Recovery ends only when time is over: if no level succeeds, the robot waits, looks again and retries all
levels with another seed, except those that were stopped from the same configuration before. See
docs/recovery.md.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pickcli.cell.tool import MOVING
from pickcli.errors import Failures, NoPlanError
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.planning.recovery.retrace import ItemRecovery, StoppedMotion
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.seeds import derived_seed
from pickcli.simulation.protective_stop import StopCause
from pickcli.trial.attempt_runner import AttemptRunner
from pickcli.trial.trial_interfaces import LONGEST_RELEASE
from pickcli.trial.trial_result import Attempt, RecoveryStep

LET_GO = "let go"  # step in which the valve is closed or the fingers are opened
WAIT = "wait"
FIRST_WAIT = 5.0  # s, doubled each time
LONGEST_WAIT = 60.0  # s
AS_HELD = 0.02  # m between the perceived item and its planned pose in the grip, if it may be held
MOST_STOPPED = 2  # stopped motions of a level from one configuration, after which it is not retried there
SAME_STOP_DISTANCE = 0.02  # rad or m of every joint
HOME_LEVELS = (RecoveryLevel.AS_PLANNED, RecoveryLevel.OPENING)  # levels that end at home


def recover(runner: AttemptRunner, attempt: Attempt, before: Scene) -> tuple[RecoveryStep, ...]:
    """Bring the arm to a safe place after an attempt that did not end as planned.

    Args:
        runner: Runs the attempts; its clock advances.
        attempt: The attempt with its execution.
        before: The perceived scene for which the attempt was planned.

    Returns:
        All steps in order of time. The last motion ended in a safe place, unless time was over before:
        then ``runner.stuck`` states that no level succeeded, or ``runner.cut_short`` that there was no
        time for one that would have.
    """
    return _Recovery(runner, attempt, before).play()


class _Recovery:
    """The state of one recovery."""

    def __init__(self, runner: AttemptRunner, attempt: Attempt, before: Scene) -> None:
        assert attempt.execution is not None and attempt.plan is not None
        self.runner, self.attempt, self.before = runner, attempt, before
        self.steps: list[RecoveryStep] = []
        self.round = 0
        self.late = ""  # the motion for which no time was left
        self.is_done = not attempt.execution.stopped  # the arm is at the end of its plan
        path_time = attempt.plan.trajectory.duration if self.is_done else attempt.execution.path_time
        # Stopped motions, each of which began where the one before stopped.
        self.trail = [] if path_time is None else [StoppedMotion(attempt.plan, path_time)]
        self.is_whole = path_time is not None  # whether the trail leads back to the start of the attempt
        self.first = 0  # first level of the next round: a level that was just stopped is not repeated
        self.in_vain: list[tuple[RecoveryLevel, Array]] = []  # stopped levels, with where they began

    @property
    def stopped(self) -> StoppedMotion | None:
        """The last motion, if the robot is still where it stopped."""
        return self.trail[-1] if self.trail else None

    def play(self) -> tuple[RecoveryStep, ...]:
        """Bring the item to a safe place, then the arm."""
        assert self.attempt.plan is not None
        if self.stopped is not None and self._may_hold():
            self._bring_item()
        if not self.runner.clock.has_time_for(LONGEST_RELEASE):
            self.runner.cut_short = "the time was over before the item had been let go"
            self.steps.append(RecoveryStep(LET_GO, self.runner.cut_short))
            return tuple(self.steps)
        # Fingers open only to the width of the approach: wider, they might hit a neighbour.
        grasp = self.attempt.plan.grasp
        opened = self.runner.let_go(None if grasp is None else grasp.tool_state)
        self.steps.append(RecoveryStep(LET_GO, "", opened))
        if not self.is_done:
            self._bring_arm_out()
        return tuple(self.steps)

    def _may_hold(self) -> bool:
        """Whether the item may be held, by what the robot can know.

        Sensors can be wrong. An item perceived elsewhere than in the grip is not held, even if the tool has
        closed on something; an item that is not perceived counts as lost only by a measurement of the tool.
        """
        runner, attempt = self.runner, self.attempt
        assert attempt.execution is not None
        is_holding = runner.interfaces.arena.is_holding()
        seen = next((placed for placed in runner.scene().items if placed.id == attempt.item), None)
        if seen is None:
            cause = attempt.execution.stop_cause
            return is_holding or cause is None or not cause.is_measured_empty
        return is_holding and self._is_seen_as_held(seen)

    def _is_seen_as_held(self, seen: PlacedItem) -> bool:
        """Whether the item is perceived where it would be if it were held as planned."""
        arena, robot, stopped = self.runner.interfaces.arena, self.before.cell.robot, self.stopped
        if stopped is None or stopped.plan.grasp is None:
            return False
        tool_state = arena.tool_state
        if tool_state == MOVING:
            tool_state = stopped.holding_state or stopped.plan.grasp.tool_state
        T_tip_item = stopped.held_item(robot, self.before.find(self.attempt.item)).T_tip_item
        T_world_held = Arm(robot).tip(arena.q, tool_state) @ T_tip_item
        off = np.linalg.norm(seen.T_world_item[:3, 3] - T_world_held[:3, 3])
        return bool(off <= AS_HELD + self.runner.scene().noise_of(seen).position)

    def _bring_item(self) -> None:
        """Move on to the destination if only the sensor, or nothing, stopped the motion; otherwise back."""
        assert self.attempt.execution is not None and self.stopped is not None
        ways = [ItemRecovery.BACK, ItemRecovery.ON]
        if self.attempt.execution.stop_cause in (None, StopCause.SENSOR):
            ways.reverse()
        scene, stopped = self._with_item_held(self.runner.scene(), self.stopped), self.stopped
        for way in ways:
            seed = derived_seed("bring", self.runner.settings.seed, self.attempt.item, self.attempt.number)

            def plan(scene: Scene = scene, way: ItemRecovery = way, seed: int = seed) -> Plan:
                return self.runner.interfaces.bring(scene, stopped, way, seed)

            if self._tried(f"bring {way}", plan, scene) is not None:
                self.is_done = False  # the arm is now elsewhere
                return

    def _with_item_held(self, scene: Scene, stopped: StoppedMotion) -> Scene:
        """The scene with the item held as planned, and in no place."""
        item = self.attempt.item
        held = stopped.held_item(scene.cell.robot, self.before.find(item))
        return replace(scene, items=tuple(p for p in scene.items if p.id != item), held=held)

    def _bring_arm_out(self) -> None:
        """Try all levels repeatedly until the arm is safe or time is over."""
        runner, patience = self.runner, FIRST_WAIT
        self.late = ""
        while not self.late and runner.has_time_to_plan:
            moved = self._round()
            if self.is_done:
                return
            if not moved and not self.late:
                self.first = 0
                duration = min(patience, runner.clock.left)
                runner.wait(duration)
                self.steps.append(RecoveryStep(WAIT, f"nothing led out; waited {duration:.0f} s"))
                patience = min(2.0 * patience, LONGEST_WAIT)
            self.round += 1
            runner.look_again()
        levels = [step.reason for step in self.steps if step.what in list(RecoveryLevel) and step.reason]
        if self.late or not levels:
            why = self.late or "nothing was tried any more"
            runner.cut_short = f"the time was over with the arm on its way out: {why}"
        else:
            runner.stuck = f"the arm could not be brought out before the time was over; last: {levels[-1]}"

    def _round(self) -> bool:
        """Try every level once, until one moves the arm. Returns whether one did."""
        runner, arena, attempt = self.runner, self.runner.interfaces.arena, self.attempt
        scene = runner.scene()
        levels = list(RecoveryLevel)
        for i in (*range(self.first, len(levels)), *range(self.first)):
            if not runner.has_time_to_plan:
                break
            level, q = levels[i], arena.q
            if self._is_in_vain(level, q):
                continue
            names = (attempt.item, attempt.number, self.round, str(level))
            seed = derived_seed("recover", runner.settings.seed, *names)

            def plan(level: RecoveryLevel = level, seed: int = seed) -> Plan:
                start = Start(arena.q, arena.tool_state)
                return runner.interfaces.recover(scene, start, seed, level, self.stopped)

            ended = self._tried(str(level), plan, scene)
            if ended is not None:
                is_back = level is RecoveryLevel.BACKWARDS and self.is_whole and not self.trail
                self.is_done = ended and (level in HOME_LEVELS or is_back)
                self.in_vain += [] if ended else [(level, q)]
                self.first = 0 if ended else (i + 1) % len(levels)
                self.late = ""
                return True
        return False

    def _is_in_vain(self, level: RecoveryLevel, q: Array) -> bool:
        """Whether a level was stopped often enough from a configuration (n,)."""
        stopped = (at for other, at in self.in_vain if other is level)
        return sum(bool(np.abs(q - at).max() <= SAME_STOP_DISTANCE) for at in stopped) >= MOST_STOPPED

    def _tried(self, what: str, plan: Callable[[], Plan], scene: Scene) -> bool | None:
        """Plan, verify and execute one step. Returns whether it reached its end; None if nothing moved."""
        runner = self.runner
        if not runner.has_time_to_plan:
            self.steps.append(RecoveryStep(what, "no time is left to plan it"))
            return None
        runner.charge()
        along = None if self.stopped is None else self.stopped.plan.trajectory
        try:
            certified = runner.certified(plan(), scene, along)
        except NoPlanError as error:
            self.steps.append(RecoveryStep(what, error.summary()))
            return None
        if isinstance(certified, Failures):
            self.steps.append(RecoveryStep(what, f"rejected: {certified.summary()}"))
            return None
        if not runner.has_time_for(certified):
            self.late = (
                f"{what} takes {certified.trajectory.duration:.1f} s, {runner.clock.left:.1f} s are left"
            )
            self.steps.append(RecoveryStep(what, self.late))
            return None
        execution = runner.execute(certified)
        self.steps.append(RecoveryStep(what, execution.stopped, execution))
        if execution.duration == 0.0:  # refused at the start
            return None
        path_time = execution.path_time
        if what == RecoveryLevel.BACKWARDS and not execution.stopped:
            self.trail.pop()
        elif what != RecoveryLevel.BACKWARDS and path_time is not None:
            stopped = StoppedMotion(certified, path_time)
            self.trail += [stopped] if stopped.has_moved else []
        else:  # no motion leads back from here
            self.trail.clear()
            self.is_whole = False
        return not execution.stopped
