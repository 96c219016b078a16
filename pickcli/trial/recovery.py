"""After a stop: bring what may be in the cup to where it may lie, then bring the arm out, whatever it takes.

Nothing here gives up but time: where no level of recovery leads anywhere, the robot waits, looks again and
tries them all with another seed. See docs/recovery.md.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from pickcli.cell.scene import Scene
from pickcli.errors import NoPlanError
from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.planning.retrace import Bringing, StoppedMotion
from pickcli.seeds import derived_seed
from pickcli.simulation.protective_stop import StopCause
from pickcli.trial.player import Player
from pickcli.trial.result import Attempt, RecoveryStep

LET_GO = "let go"  # the step in which the vacuum is switched off
WAIT = "wait"
FIRST_WAIT = 5.0  # s, doubled each time
LONGEST_WAIT = 60.0  # s
HOME_LEVELS = (RecoveryLevel.AS_PLANNED, RecoveryLevel.OPENING)  # they end at home
VACUUM_GONE = (StopCause.SEAL_LOST, StopCause.NOT_SEALED)  # measured in the cup, not a sensor's yes or no


def recover(player: Player, attempt: Attempt, before: Scene) -> tuple[RecoveryStep, ...]:
    """Bring the arm to a safe place after an attempt that did not end as planned.

    Args:
        player: Who plays; its clock goes on.
        attempt: The attempt with its execution.
        before: The scene as it was seen when the attempt was planned.

    Returns:
        Every step that was tried, in the order of time. The last one that moved ended in a safe place, unless
        the time was over before: then ``player.stuck`` says so.
    """
    return _Recovery(player, attempt, before).play()


class _Recovery:
    """The state of one recovery."""

    def __init__(self, player: Player, attempt: Attempt, before: Scene) -> None:
        assert attempt.execution is not None and attempt.plan is not None
        self.player, self.attempt, self.before = player, attempt, before
        self.steps: list[RecoveryStep] = []
        self.round = 0
        self.is_over = False  # there is a way out, and no time left for it
        path_time = attempt.execution.path_time
        # Motions that stopped, each begun where the one before stopped: the way back to where it all began.
        self.trail = [] if path_time is None else [StoppedMotion(attempt.plan, path_time)]
        self.first = 0  # level with which the next round begins: what has just met something is not repeated
        self.is_done = not attempt.execution.stopped  # it stands where its plan ends

    @property
    def stopped(self) -> StoppedMotion | None:
        """The last motion that stopped, if the robot still stands where it did."""
        return self.trail[-1] if self.trail else None

    def play(self) -> tuple[RecoveryStep, ...]:
        """First the item, then the arm."""
        if self.stopped is not None and self._may_hold():
            self._bring_item()
        self.steps.append(RecoveryStep(LET_GO, "", self.player.let_go()))
        if not self.is_done:
            self._bring_arm_out()
        return tuple(self.steps)

    def _may_hold(self) -> bool:
        """Whether the item can be in the cup, for all that a robot knows.

        A sensor can be wrong. An item that it denies and that is seen where it was is not in the cup.
        """
        player, attempt = self.player, self.attempt
        assert attempt.execution is not None
        if player.crew.arena.has_vacuum():
            return True
        if attempt.execution.stop_cause in VACUUM_GONE:
            return False
        return all(placed.id != attempt.item for placed in player.scene().items)

    def _bring_item(self) -> None:
        """On to where it was to be let go if only the sensor stopped the motion, back into its bin if not."""
        assert self.attempt.execution is not None and self.stopped is not None
        ways = [Bringing.BACK, Bringing.ON]
        if self.attempt.execution.stop_cause is StopCause.SENSOR:
            ways.reverse()
        stopped = self.stopped
        scene, taken = self.player.scene(), self.before.find(self.attempt.item)
        scene = replace(scene, held=stopped.in_the_cup(scene.cell.robot, taken))
        for way in ways:
            seed = derived_seed("bring", self.player.settings.seed, self.attempt.item, self.attempt.number)

            def plan(scene: Scene = scene, way: Bringing = way, seed: int = seed) -> Plan:
                return self.player.crew.bring(scene, stopped, way, seed)

            if self._tried(f"bring {way}", plan, scene):
                return

    def _bring_arm_out(self) -> None:
        """Level after level, again and again, until the arm is out or the time is over."""
        player, patience = self.player, FIRST_WAIT
        while player.clock.left > 0.0:
            moved = self._round()
            if self.is_done or self.is_over:
                return
            if not moved:
                self.first = 0
                duration = min(patience, player.clock.left)
                player.wait(duration)
                self.steps.append(RecoveryStep(WAIT, f"nothing led out; waited {duration:.0f} s"))
                patience = min(2.0 * patience, LONGEST_WAIT)
            self.round += 1
            player.look()
        last = next((step.reason for step in reversed(self.steps) if step.what != WAIT and step.reason), "")
        player.stuck = f"the arm could not be brought out before the time was over; last: {last}"

    def _round(self) -> bool:
        """Every level once, until one has moved the arm. Returns whether one did."""
        player, arena, attempt = self.player, self.player.crew.arena, self.attempt
        scene = player.scene()
        levels = list(RecoveryLevel)
        for i in (*range(self.first, len(levels)), *range(self.first)):
            level = levels[i]
            names = (attempt.item, attempt.number, self.round, str(level))
            seed = derived_seed("recover", player.settings.seed, *names)

            def plan(level: RecoveryLevel = level, seed: int = seed) -> Plan:
                return player.crew.recover(scene, arena.q, arena.pivot, seed, level, self.stopped)

            ended = self._tried(str(level), plan, scene)
            if ended is not None:
                is_back = level is RecoveryLevel.BACKWARDS and not self.trail
                self.is_done = ended and (level in HOME_LEVELS or is_back)
                self.first = 0 if ended else (i + 1) % len(levels)
                return True
            if self.is_over:
                break
        return False

    def _tried(self, what: str, plan: Callable[[], Plan], scene: Scene) -> bool | None:
        """Plan, verify and execute one step. Whether it went to its end; None if it did not move at all."""
        player = self.player
        player.charge()
        try:
            certified = player.certified(plan(), scene)
        except NoPlanError as error:
            self.steps.append(RecoveryStep(what, error.summary()))
            return None
        if isinstance(certified, str):
            self.steps.append(RecoveryStep(what, f"rejected: {certified}"))
            return None
        if not player.clock.has_time_for(certified.trajectory.duration):
            left = f"takes {certified.trajectory.duration:.1f} s, {player.clock.left:.1f} s are left"
            self.steps.append(RecoveryStep(what, left))
            self.is_over = True
            return None
        execution = player.execute(certified)
        self.steps.append(RecoveryStep(what, execution.stopped, execution))
        if execution.duration == 0.0:  # refused at its start
            return None
        path_time = execution.path_time
        if what == RecoveryLevel.BACKWARDS and not execution.stopped:
            self.trail.pop()
        elif what != RecoveryLevel.BACKWARDS and path_time is not None:
            self.trail.append(StoppedMotion(certified, path_time))
        else:
            self.trail.clear()
        return not execution.stopped
