"""A whole trial: look, plan, verify, execute, judge, again; until done or out of time.

Whatever is random follows from the seed, whatever is timed from simulated time and counted planning calls:
two runs of one trial differ in nothing but ``statistics``.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

from pickcli.cell.scene import TOTE, PlacedItem, PoseNoise, Scene
from pickcli.errors import InputError, NoPlanError
from pickcli.geometry import inverse
from pickcli.seeds import derived_seed
from pickcli.trial.final import final_state
from pickcli.trial.noise import DEFAULT_NOISE, perceive
from pickcli.trial.order import Order, OrderKind
from pickcli.trial.ports import Crew, Execution
from pickcli.trial.result import Attempt, Outcome, TargetResult, TrialResult
from pickcli.trial.score import item_bonuses, score
from pickcli.trial.strategy import TIME_LIMIT, Job, TrialClock, jobs_of, next_job

Progress: TypeAlias = Callable[[int, int, str], None]  # targets done, targets in all, what happens now

MAX_RECOVERIES = 2  # motions that may be tried to bring the arm out after one attempt


@dataclass(frozen=True)
class TrialSettings:
    """How a trial is played."""

    seed: int = 0
    noise: PoseNoise = DEFAULT_NOISE
    time_limit: float | None = None  # s, None: that of the order's year


def run_trial(
    order: Order,
    crew: Crew,
    settings: TrialSettings | None = None,
    progress: Progress = lambda done, total, what: None,
) -> TrialResult:
    """Play a pick order to its end. What goes wrong is part of the result, see TrialResult.aborted.

    Raises InputError for an order that is no pick order.
    """
    trial = _Trial(require_pick(order), crew, settings or TrialSettings(), progress)
    trial.play()
    return trial.result()


def require_pick(order: Order, where: str = "the order") -> Order:
    """The order, if it is one that can be played. Raises InputError."""
    if order.kind is not OrderKind.PICK:
        raise InputError(
            f"{where}: this is a {order.kind} file; a trial plays pick orders (with a work_order)"
        )
    return order


class _Trial:
    """The state of a trial: open jobs, the clock, and what happened so far."""

    def __init__(self, order: Order, crew: Crew, settings: TrialSettings, progress: Progress) -> None:
        self.order, self.crew, self.settings, self.progress = order, crew, settings, progress
        self.before = crew.arena.now()
        cell = self.before.cell
        self.bonus = item_bonuses(cell, order)
        self.jobs = jobs_of(order, cell, self.bonus)
        self.open = list(self.jobs)
        limit = settings.time_limit
        self.clock = TrialClock(TIME_LIMIT[order.year] if limit is None else limit)
        self.attempts: list[tuple[Job, Attempt]] = []
        self.n_looks = 0
        self.aborted = ""

    def play(self) -> None:
        """Attempt after attempt, the most promising first."""
        while self.open and not self.aborted:
            job = next_job(self.open)
            attempt = self._attempt(job)
            self.attempts.append((job, attempt))
            self._update(job, attempt)
        self.progress(len(self.jobs), len(self.jobs), "done")

    def _update(self, job: Job, attempt: Attempt) -> None:
        """Close the job, or put it back with what was learned."""
        self.open.remove(job)
        seconds = attempt.plan.trajectory.duration if attempt.plan else None
        grasp = attempt.plan.grasp if attempt.plan else None
        retried = job.failed(grasp, seconds)
        is_over = attempt.outcome in (Outcome.IN_TOTE, Outcome.MISSING, Outcome.NO_TIME)
        if not is_over and retried.is_retriable:
            self.open.append(retried)

    def _attempt(self, job: Job) -> Attempt:
        attempt = Attempt(job.target, "", job.attempts + 1, self.clock.now, Outcome.NO_TIME)
        if not self.clock.has_time_for(self.clock.charge):
            return replace(attempt, reason=f"the {self.clock.limit:.0f} s of the trial are over")
        scene = self._look()
        placed = _choose_copy(scene, job)
        if placed is None:
            what = f"no {job.target.item} is left in {job.target.bin}"
            return replace(attempt, outcome=Outcome.MISSING, reason=what)
        attempt = replace(attempt, item=placed.id)
        self._say(job, "planning")
        planned = self._plan(attempt, job, scene)
        if planned.plan is None:
            return planned
        verified = self._verify(planned, scene)
        if verified.outcome is Outcome.REJECTED:
            return verified
        return self._execute(verified, job)

    def _plan(self, attempt: Attempt, job: Job, scene: Scene) -> Attempt:
        began = time.perf_counter()
        self.clock = self.clock.planned()
        arena, target = self.crew.arena, job.target
        seed = derived_seed("plan", self.settings.seed, attempt.item, attempt.number)
        try:
            plan = self.crew.plan(
                scene, target.bin, attempt.item, arena.q, arena.pivot, seed, job.failed_grasps
            )
        except NoPlanError as error:
            statistics = {"planning_ms": _ms_since(began)}
            reason = error.summary()
            return replace(attempt, outcome=Outcome.NO_PLAN, reason=reason, statistics=statistics)
        return replace(attempt, plan=plan, statistics={**plan.statistics, "planning_ms": _ms_since(began)})

    def _verify(self, attempt: Attempt, scene: Scene) -> Attempt:
        """The attempt with its plan certified, or rejected: nothing uncertified is executed."""
        assert attempt.plan is not None
        began = time.perf_counter()
        verdict = self.crew.verify(attempt.plan, scene)
        statistics = {**attempt.statistics, "verification_ms": _ms_since(began)}
        if verdict.certificate is None:
            reason = str(NoPlanError(attempt.plan.query, verdict.reasons).summary())
            return replace(attempt, outcome=Outcome.REJECTED, reason=reason, statistics=statistics)
        plan = replace(attempt.plan, certificate=verdict.certificate)
        return replace(attempt, plan=plan, statistics=statistics)

    def _execute(self, attempt: Attempt, job: Job) -> Attempt:
        assert attempt.plan is not None
        duration = attempt.plan.trajectory.duration
        if not self.clock.has_time_for(duration):
            reason = f"the motion takes {duration:.1f} s, {self.clock.left:.1f} s are left"
            return replace(attempt, outcome=Outcome.NO_TIME, reason=reason)
        self._say(job, "moving")
        execution = self._timed(self.crew.arena.execute(attempt.plan))
        recovery = self._recover(attempt) if execution.stopped or self.crew.arena.held else ()
        outcome, reason = self._judge(attempt, execution)
        return replace(attempt, execution=execution, recovery=recovery, outcome=outcome, reason=reason)

    def _timed(self, execution: Execution) -> Execution:
        self.clock = self.clock.moved(execution.duration)
        return execution

    def _judge(self, attempt: Attempt, execution: Execution) -> tuple[Outcome, str]:
        """Where the item really is decides; the sensor and the stop say why."""
        scene = self.crew.arena.now()
        ids = {placed.id: placed.location for placed in scene.items}
        where = ids.get(attempt.item, "the cup")
        if where == TOTE:
            return Outcome.IN_TOTE, ""
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
            scene = self._look()
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

    def _look(self) -> Scene:
        self.n_looks += 1
        return perceive(self.crew.arena.now(), self.settings.noise, self.settings.seed, self.n_looks)

    def _say(self, job: Job, doing: str) -> None:
        n_done = len(self.jobs) - len(self.open)
        what = (
            f"{job.target.bin} {job.target.item}: {doing}, {self.clock.left:.0f} s left on the trial's clock"
        )
        self.progress(n_done, len(self.jobs), what)

    def result(self) -> TrialResult:
        """Everything measured, with the score of where the items really are."""
        arena = self.crew.arena
        after = arena.now()
        attempts = tuple(attempt for _, attempt in self.attempts)
        drops = tuple(d for attempt in attempts for e in attempt.executions for d in e.drops)
        final = final_state(self.order, self.before, after, self._look(), arena.held, drops)
        return TrialResult(
            self.order, self.settings.seed, self.settings.noise,
            tuple(self._target_result(job) for job in self.jobs), attempts, self.before, after,
            final, score(self.order, final, self.bonus), self.clock.simulated, self.clock.now, self.aborted,
        )  # fmt: skip

    def _target_result(self, job: Job) -> TargetResult:
        own = tuple(attempt for j, attempt in self.attempts if j.index == job.index)
        if not own:
            return TargetResult(job.target, Outcome.NO_TIME, f"trial aborted: {self.aborted}", 0, ())
        points = job.points if own[-1].outcome is Outcome.IN_TOTE else 0
        return TargetResult(job.target, own[-1].outcome, own[-1].reason, points, own)


def _choose_copy(scene: Scene, job: Job) -> PlacedItem | None:
    """Of several copies in the bin the one nearest to its mouth; on a retry the next one."""
    T_pod_world = inverse(scene.T_world_pod)
    copies = [i for i in scene.in_location(job.target.bin) if i.item.name == job.target.item]
    copies.sort(key=lambda i: (float((T_pod_world @ i.T_world_item)[0, 3]), i.id))
    return copies[job.attempts % len(copies)] if copies else None


def _ms_since(began: float) -> float:
    return 1e3 * (time.perf_counter() - began)
