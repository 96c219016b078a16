"""One attempt after another: plan, verify, execute, judge, and bring the arm out where that went wrong."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from pickcli.cell.scene import TOTE, PoseNoise, Scene
from pickcli.errors import NoPlanError
from pickcli.motion.plan import Grasp, Plan
from pickcli.seeds import derived_seed
from pickcli.simulation.reality import DEFAULT, Reality
from pickcli.trial.noise import DEFAULT_NOISE, perceive
from pickcli.trial.ports import Crew, Execution
from pickcli.trial.result import Attempt, Outcome
from pickcli.trial.strategy import TrialClock

MAX_RECOVERIES = 2  # motions that may be tried to bring the arm out after one attempt


@dataclass(frozen=True)
class TrialSettings:
    """How a trial is played."""

    seed: int = 0
    noise: PoseNoise = DEFAULT_NOISE
    reality: Reality = DEFAULT
    time_limit: float | None = None  # s, None: that of the order's year


class Player:
    """A crew with a clock.

    aborted: why no more can be played, "" while it can. say: told what happens now
    """

    def __init__(
        self, crew: Crew, settings: TrialSettings, limit: float, say: Callable[[Attempt, str], None]
    ) -> None:
        self.crew, self.settings, self.say = crew, settings, say
        self.clock = TrialClock(limit)
        self.n_looks = 0
        self.aborted = ""

    def look(self) -> Scene:
        """The scene as it is perceived now."""
        self.n_looks += 1
        return perceive(self.crew.arena.now(), self.settings.noise, self.settings.seed, self.n_looks)

    def plan(self, scene: Scene, attempt: Attempt, exclude: Sequence[Grasp] = ()) -> Plan:
        """One call of the planner, charged to the clock. Raises NoPlanError."""
        self.clock = self.clock.planned()
        arena = self.crew.arena
        names = (attempt.item, attempt.number, *(() if attempt.into == TOTE else (attempt.into,)))
        seed = derived_seed("plan", self.settings.seed, *names)
        where = (attempt.target.bin, attempt.item, attempt.into)
        return self.crew.plan(scene, *where, arena.q, arena.pivot, seed, exclude)

    def attempt(self, attempt: Attempt, scene: Scene, exclude: Sequence[Grasp] = ()) -> Attempt:
        """Play one attempt to its end, whatever that is."""
        self.say(attempt, "planning")
        planned = self.planned(attempt, scene, exclude)
        return planned if planned.plan is None else self.carried_out(planned, scene)

    def planned(self, attempt: Attempt, scene: Scene, exclude: Sequence[Grasp] = ()) -> Attempt:
        """The attempt with its plan, or with the reason why there is none."""
        began = time.perf_counter()
        try:
            plan = self.plan(scene, attempt, exclude)
        except NoPlanError as error:
            statistics = {"planning_ms": _ms_since(began)}
            reason = error.summary()
            return replace(attempt, outcome=Outcome.NO_PLAN, reason=reason, statistics=statistics)
        return replace(attempt, plan=plan, statistics={**plan.statistics, "planning_ms": _ms_since(began)})

    def carried_out(self, attempt: Attempt, scene: Scene) -> Attempt:
        """A planned attempt, verified and executed: nothing uncertified is."""
        verified = self._verified(attempt, scene)
        return verified if verified.outcome is Outcome.REJECTED else self._executed(verified)

    def _verified(self, attempt: Attempt, scene: Scene) -> Attempt:
        assert attempt.plan is not None
        began = time.perf_counter()
        verdict = self.crew.verify(attempt.plan, scene)
        statistics = {**attempt.statistics, "verification_ms": _ms_since(began)}
        if verdict.certificate is None:
            reason = str(NoPlanError(attempt.plan.query, verdict.reasons).summary())
            return replace(attempt, outcome=Outcome.REJECTED, reason=reason, statistics=statistics)
        plan = replace(attempt.plan, certificate=verdict.certificate)
        return replace(attempt, plan=plan, statistics=statistics)

    def _executed(self, attempt: Attempt) -> Attempt:
        assert attempt.plan is not None
        duration = attempt.plan.trajectory.duration
        if not self.clock.has_time_for(duration):
            reason = f"the motion takes {duration:.1f} s, {self.clock.left:.1f} s are left"
            return replace(attempt, outcome=Outcome.NO_TIME, reason=reason)
        self.say(attempt, "moving")
        execution = self._timed(self.crew.arena.execute(attempt.plan))
        recovery = self._recover(attempt) if execution.stopped or self.crew.arena.held else ()
        outcome, reason = self._judged(attempt, execution)
        return replace(attempt, execution=execution, recovery=recovery, outcome=outcome, reason=reason)

    def _timed(self, execution: Execution) -> Execution:
        self.clock = self.clock.moved(execution.duration)
        return execution

    def _judged(self, attempt: Attempt, execution: Execution) -> tuple[Outcome, str]:
        """Where the item really is decides; the sensor and the stop say why."""
        ids = {placed.id: placed.location for placed in self.crew.arena.now().items}
        where = ids.get(attempt.item, "the cup")
        if where == attempt.into:
            return (Outcome.IN_TOTE if where == TOTE else Outcome.MOVED), ""
        cause = execution.stopped or "it was let go"
        if execution.has_item is False:
            return Outcome.NOT_PICKED, f"{cause}; no vacuum after the retreat, the item is in {where}"
        return Outcome.LOST, f"{cause}; the item is in {where}"

    def _recover(self, attempt: Attempt) -> tuple[Execution, ...]:
        """Bring the arm out to a safe place; where that fails the trial ends."""
        arena = self.crew.arena
        done: list[Execution] = []
        if arena.held is not None:  # a motion that stopped is not trusted to hold on
            done.append(self._timed(arena.release()))
        for k in range(MAX_RECOVERIES):
            self.clock = self.clock.planned()
            scene = self.look()
            seed = derived_seed("recover", self.settings.seed, attempt.item, attempt.number, k)
            try:
                plan = self.crew.recover(scene, arena.q, arena.pivot, seed)
            except NoPlanError as error:
                self.aborted = f"the arm cannot be brought out: {error}"
                return tuple(done)
            verdict = self.crew.verify(plan, scene)
            if verdict.certificate is None:
                self.aborted = f"the way out is not certified: {'; '.join(map(str, verdict.reasons[:3]))}"
                return tuple(done)
            done.append(self._timed(arena.execute(replace(plan, certificate=verdict.certificate))))
            if not done[-1].stopped:
                return tuple(done)
        self.aborted = f"the arm did not come out: {done[-1].stopped}"
        return tuple(done)


def _ms_since(began: float) -> float:
    return 1e3 * (time.perf_counter() - began)
