"""A whole trial: the most promising job next, until all is done or the time is over.

Whatever is random follows from the seed, whatever is timed from simulated time and counted planning calls:
two runs of one trial differ in nothing but ``statistics``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

from pickcli.cell.scene import TOTE, PlacedItem, Scene
from pickcli.errors import InputError
from pickcli.geometry import inverse
from pickcli.trial.clearing import destinations, in_the_way
from pickcli.trial.final import final_state
from pickcli.trial.order import Order, OrderKind
from pickcli.trial.player import Player, TrialSettings
from pickcli.trial.ports import Crew
from pickcli.trial.result import Attempt, Outcome, TargetResult, TrialResult
from pickcli.trial.score import Score, item_bonuses, score
from pickcli.trial.strategy import TIME_LIMIT, Job, jobs_of, may_move_others, next_job

Progress: TypeAlias = Callable[[int, int, str], None]  # targets done, targets in all, what happens now


def run_trial(
    order: Order,
    crew: Crew,
    settings: TrialSettings | None = None,
    progress: Progress = lambda done, total, what: None,
) -> TrialResult:
    """Play a pick order to its end. What goes wrong is part of the result.

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
    """The state of a trial: open jobs and what happened so far."""

    def __init__(self, order: Order, crew: Crew, settings: TrialSettings, progress: Progress) -> None:
        self.order, self.crew, self.settings, self.progress = order, crew, settings, progress
        self.before = crew.arena.now()
        cell = self.before.cell
        self.bonus = item_bonuses(cell, order)
        self.jobs = jobs_of(order, cell, self.bonus)
        self.open = list(self.jobs)
        self.blocked: list[Job] = []  # no plan, whatever was tried: something may be in the way
        limit = TIME_LIMIT[order.year] if settings.time_limit is None else settings.time_limit
        self.player = Player(crew, settings, limit, self._say)
        self.attempts: list[tuple[Job, Attempt]] = []

    def play(self) -> None:
        """Attempt after attempt, the most promising first; then what must be made accessible."""
        while self.open or self.blocked:
            if self.open:
                self._pick(next_job(self.open))
            else:
                self._clear(next_job(self.blocked))
        self.progress(len(self.jobs), len(self.jobs), "done")

    def _pick(self, job: Job) -> None:
        attempt = self._attempt(job)
        self.attempts.append((job, attempt))
        self.open.remove(job)
        seconds = attempt.plan.trajectory.duration if attempt.plan else None
        tried = job.failed(attempt.plan.grasp if attempt.plan else None, seconds)
        if attempt.outcome in (Outcome.IN_TOTE, Outcome.MISSING, Outcome.NO_TIME):
            return
        if tried.is_retriable:
            self.open.append(tried)
        elif attempt.outcome is Outcome.NO_PLAN and tried.is_clearable and may_move_others(self.order.year):
            self.blocked.append(tried)

    def _attempt(self, job: Job) -> Attempt:
        player = self.player
        attempt = Attempt(job.target, "", job.attempts + 1, player.clock.now, Outcome.NO_TIME)
        if not player.clock.has_time_for(player.clock.charge):
            return replace(attempt, reason=f"the {player.clock.limit:.0f} s of the trial are over")
        scene = player.scene()
        placed = _choose_copy(scene, job)
        if placed is None:
            what = f"no {job.target.item} is left in {job.target.bin}"
            return replace(attempt, outcome=Outcome.MISSING, reason=what)
        return player.attempt(replace(attempt, item=placed.id), scene, job.failed_grasps)

    def _clear(self, job: Job) -> None:
        """Move one item aside that is in the way of a target, and open the target's job again."""
        self.blocked.remove(job)
        scene, target = self.player.scene(), job.target
        placed = _choose_copy(scene, job)
        if placed is None:
            return
        wanted = Attempt(target, placed.id, job.attempts + 1, self.player.clock.now, Outcome.NO_PLAN)
        self.player.say(wanted, "looking for what is in the way")
        for name in in_the_way(lambda without: self.player.plan(without, wanted), scene, target.bin):
            aside = self._moved_aside(replace(wanted, item=name), scene)
            self.attempts.append((job, aside))
            if aside.outcome is Outcome.MOVED:
                self.open.append(job.cleared_once())
            if aside.plan is not None:  # the scene has changed
                return

    def _moved_aside(self, attempt: Attempt, scene: Scene) -> Attempt:
        """An attempt to bring an item into another bin, whichever takes it first."""
        player, last = self.player, attempt
        targets = [job.target for job in (*self.open, *self.blocked)]
        for into in destinations(scene, attempt.target.bin, targets):
            if not player.clock.has_time_for(player.clock.charge):
                break
            last = player.attempt(replace(attempt, into=into, t_start=player.clock.now), scene)
            if last.plan is not None:
                break
        return last

    def _say(self, attempt: Attempt, doing: str) -> None:
        n_done = len(self.jobs) - len(self.open) - len(self.blocked)
        what = attempt.target.item if attempt.into == TOTE else f"{attempt.item} aside"
        left = f"{self.player.clock.left:.0f} s left on the trial's clock"
        self.progress(n_done, len(self.jobs), f"{attempt.target.bin} {what}: {doing}, {left}")

    def result(self) -> TrialResult:
        """Everything measured, with the score of where the items really are."""
        arena, player = self.crew.arena, self.player
        after = arena.now()
        attempts = tuple(attempt for _, attempt in self.attempts)
        drops = tuple(d for attempt in attempts for e in attempt.executions for d in e.drops)
        final = final_state(self.order, self.before, after, player.scene(), arena.held, drops)
        points = score(self.order, final, self.bonus)
        return TrialResult(
            self.order, self.settings.seed, self.settings.noise, self.settings.reality,
            tuple(self._target_result(job, points) for job in self.jobs), attempts, self.before, after,
            final, points, player.clock.simulated, player.clock.now, player.stuck,
        )  # fmt: skip

    def _target_result(self, job: Job, score: Score) -> TargetResult:
        own = tuple(attempt for j, attempt in self.attempts if j.index == job.index)
        picks = [attempt for attempt in own if attempt.into == TOTE]
        points = score.lines[job.index].points  # the lines of the targets come first, in their order
        if not picks:
            return TargetResult(job.target, Outcome.NO_TIME, "the time was over", points, own)
        last = next((a for a in reversed(picks) if a.outcome is not Outcome.NO_TIME), picks[-1])
        return TargetResult(job.target, last.outcome, last.reason, points, own)


def _choose_copy(scene: Scene, job: Job) -> PlacedItem | None:
    """Of several copies in the bin the one nearest to its mouth; on a retry the next one."""
    T_pod_world = inverse(scene.T_world_pod)
    copies = [i for i in scene.in_location(job.target.bin) if i.item.name == job.target.item]
    copies.sort(key=lambda i: (float((T_pod_world @ i.T_world_item)[0, 3]), i.id))
    return copies[job.attempts % len(copies)] if copies else None
