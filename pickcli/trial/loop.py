"""Plays a whole trial by a strategy, until all targets are done, the strategy ends or time is over.

Randomness depends only on the seed, and time only on simulated time and the number of planning calls: two
runs of a trial differ only in ``statistics``.
"""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TypeAlias

from pickcli.motion.plan import Grasp, GraspKind
from pickcli.planning.blockers import from_the_mouth
from pickcli.progress import Progress, ProgressObserver, nobody
from pickcli.scene.scene import TOTE, PlacedItem, Scene
from pickcli.simulation.protective_stop import StopCause
from pickcli.strategy.name_check import unknown_names
from pickcli.strategy.strategy_player import StrategyPlayer
from pickcli.strategy.trial_actions import OpenTarget
from pickcli.trial.action_values import AttemptOutcomes, TargetState, open_targets, target_states
from pickcli.trial.attempt_execution import carry_out
from pickcli.trial.attempt_runner import AttemptRunner, TrialSettings
from pickcli.trial.clearing import Clearing, destinations
from pickcli.trial.damage import damages
from pickcli.trial.disturbance import DisturbanceKind
from pickcli.trial.final_state import Drop, final_state
from pickcli.trial.order import (
    ANY_BIN,
    Order,
    OrderKind,
    Target,
    may_move_others,
    require_playable,
    time_limit,
)
from pickcli.trial.room_making import items_in_the_place_of
from pickcli.trial.score import Score, item_bonuses, score
from pickcli.trial.stow_assignment import assign_bins
from pickcli.trial.toppling_memory import TopplingMemory
from pickcli.trial.trial_interfaces import TrialInterfaces
from pickcli.trial.trial_result import Attempt, Outcome, TargetResult, TrialResult

NO_TIME_TO_PLAN = "no time is left to plan it"
ResultObserver: TypeAlias = Callable[[Callable[[], TrialResult]], None]

_log = logging.getLogger(__name__)


def nobody_asks(result: Callable[[], TrialResult]) -> None:
    """Ignore the result of an attempt.

    Args:
        result: Returns the result so far.
    """


def run_trial(
    order: Order,
    interfaces: TrialInterfaces,
    settings: TrialSettings | None = None,
    on_progress: ProgressObserver = nobody,
    after_attempt: ResultObserver = nobody_asks,
) -> TrialResult:
    """Play an order to its end. Failures are part of the result.

    Args:
        order: A pick or stow order, or moves.
        interfaces: Planner, verifier and arena.
        settings: Settings of the trial; None for the default.
        on_progress: Called with the number of finished targets and the present action.
        after_attempt: Called after every attempt, at a target or at a blocking item, with a function that
            returns the result so far.

    Returns:
        The events and the score.

    Raises:
        InputError: The order cannot be played.
    """
    trial = _Trial(
        require_playable(order), interfaces, settings or TrialSettings(), on_progress, after_attempt
    )
    try:
        trial.play()
    except KeyboardInterrupt as stop:
        stop.add_note(trial.so_far())
        raise
    return trial.result(trial.runner.scene())  # may take another look, before counting


class _Trial:
    """The state of a trial, and the ``TrialActions`` of its strategy.

    homes: by id, the place in which each item was seen at the start
    delivered: ids of the items brought to their destinations
    bins: of a stow, by item name the bins to try, in this order
    in_vain: failed grasps, by item id
    refused: by target index, the scene and item of a failed plan, with the items that it blamed
    stuck: the scene as last perceived, and by id failed attempts at what cannot leave its place in it
    no_room: by id of an item of the tote, contents of the bins in which no room could be made for it
    """

    def __init__(
        self,
        order: Order,
        interfaces: TrialInterfaces,
        settings: TrialSettings,
        on_progress: ProgressObserver,
        after_attempt: ResultObserver = nobody_asks,
    ) -> None:
        self.order, self.interfaces, self.settings, self.on_progress = (
            order,
            interfaces,
            settings,
            on_progress,
        )
        self.after_attempt = after_attempt
        self.before = interfaces.arena.now()
        cell = self.before.cell
        self.bonus = item_bonuses(cell, order)
        self.bins: dict[str, tuple[str, ...]] = {}
        if order.kind is OrderKind.STOW:
            self.bins = {
                each.item: each.bins for each in assign_bins(order, cell, self.bonus, settings.stow_rule)
            }
        self.tools = [each.robot.tool for each in (interfaces.cells or {"": cell}).values()]
        self.targets = target_states(order, cell, self.bonus, self.tools)
        self.open = {state.index: state for state in self.targets}
        limit = time_limit(order) if settings.time_limit is None else settings.time_limit
        self.runner = AttemptRunner(interfaces, settings, limit, self._say)
        self.outcomes = AttemptOutcomes()
        self.homes: dict[str, str] = {}
        self.delivered: set[str] = set()
        self.in_vain: dict[str, tuple[Grasp, ...]] = {}
        self.refused: dict[int, tuple[Scene, str, tuple[str, ...]]] = {}
        self.stuck: tuple[Scene, dict[str, Attempt]] = (self.before, {})
        self.no_room: dict[str, frozenset[tuple[str, str]]] = {}
        self.toppling = TopplingMemory()
        self.attempts: list[tuple[TargetState, Attempt]] = []
        self.player = StrategyPlayer(settings.strategy, self)
        names = {name for name, _ in cell.items} | {placed.item.name for placed in self.before.items}
        for line in unknown_names(settings.strategy, names, cell.places):
            _log.warning("strategy %s: %s", settings.strategy.name, line)

    def play(self) -> None:
        """Tick the strategy until nothing is left that it would try, or time is over."""
        self.homes = {placed.id: placed.location for placed in self.runner.scene().items}
        self.player.play()
        self.on_progress(Progress(len(self.targets), len(self.targets), "done"))

    @property
    def now(self) -> float:
        """Time on the trial's clock, s."""
        return self.runner.clock.now

    @property
    def time_left(self) -> float:
        """Time until the end of the trial, s."""
        return self.runner.clock.left

    @property
    def has_time_to_plan(self) -> bool:
        """Whether one more planning call would end in time."""
        return self.runner.has_time_to_plan

    def open_targets(self) -> tuple[OpenTarget, ...]:
        """Return the targets for which something can still be tried, in the order of their lines."""
        n_items = Counter(placed.location for placed in self.runner.last_scene.items)
        return open_targets(self.open.values(), self.outcomes, may_move_others(self.order), n_items)

    def look(self) -> bool:
        """Look again; every look has different errors. False if there is no time."""
        return self.runner.look_again()

    def so_far(self) -> str:
        """Describe what an interrupted trial loses, and how to repeat it."""
        n_in = sum(attempt.outcome.is_delivered for _, attempt in self.attempts)
        where = "in the tote" if self.order.kind is OrderKind.PICK else "delivered"
        played = f"{n_in} of {len(self.targets)} targets were {where} after {len(self.attempts)} attempts"
        return f"{played}; a trial cannot be continued: the same command plays it again from the start"

    def pick(self, index: int) -> bool:
        """Make one attempt at a target, and update its state; return whether it is delivered."""
        state = self.open[index].tried()
        attempt = self._attempt(state)
        self._note(state, attempt)
        if attempt.outcome.is_delivered or attempt.outcome in (Outcome.MISSING, Outcome.NO_TIME):
            self.open.pop(state.index, None)
        elif attempt.execution is None:
            self.open[state.index] = state.refused()
            if attempt.outcome in (Outcome.NO_PLAN, Outcome.REJECTED):
                self.refused[state.index] = (self.runner.scene(), attempt.item, attempt.in_the_way)
                for name in (attempt.item, *attempt.in_the_way):
                    if self._topple(self.open[state.index], name):
                        break
        else:
            self.open[state.index] = self.open[state.index].failed()
        return attempt.outcome.is_delivered

    def _topple(self, state: TargetState, name: str) -> bool:
        """Topple an item that no tool can take as it stands; return whether something was tried for it."""
        scene = self.runner.scene()
        placed = next((placed for placed in scene.items if placed.id == name), None)
        if placed is None or not self.toppling.is_due(placed) or not self.runner.has_time_to_plan:
            return False
        attempt = Attempt(
            state.target, name, state.attempts, self.runner.clock.now, Outcome.NO_PLAN,
            into=placed.location, out_of=placed.location, is_aside=True, topples=True,
        )  # fmt: skip
        self.runner.say(attempt, "planning to topple it")
        planned = self.runner.toppling(attempt, scene)
        self._note(state, planned if planned.plan is None else carry_out(self.runner, planned))
        return self.attempts[-1][1].execution is not None

    def give_up(self, index: int) -> None:
        """Close a target."""
        self.open.pop(index, None)

    def _attempt(self, state: TargetState) -> Attempt:
        scene = self.runner.scene()
        now, into = self.runner.clock.now, state.target.into
        attempt = Attempt(state.target, "", state.attempts, now, Outcome.MISSING, into=into)
        placed = self._choose_copy(scene, state)
        if placed is None:
            return replace(attempt, reason=f"no {state.target.item} of {state.target.bin} is seen any more")
        return self._moved(replace(attempt, item=placed.id, out_of=placed.location), scene)

    def _moved(self, attempt: Attempt, scene: Scene) -> Attempt:
        """Play an attempt to its end and return it with its outcome."""
        if attempt.into == ANY_BIN:
            return self._stowed(attempt, scene)
        planned = self._planned(attempt, scene)
        return planned if planned.plan is None else carry_out(self.runner, planned)

    def _stowed(self, attempt: Attempt, scene: Scene) -> Attempt:
        """Try to bring an item into the first of its bins that has room, unless it cannot leave its place."""
        if not self.runner.has_time_to_plan:
            return replace(attempt, outcome=Outcome.NO_TIME, reason=NO_TIME_TO_PLAN)
        first: Attempt | None = None
        for name in self.bins[attempt.target.item]:
            if not self.runner.has_time_to_plan:
                break
            tried = self._moved(replace(attempt, into=name), scene)
            if tried.execution is not None or tried.outcome is Outcome.NO_TIME:
                is_there = self.order.is_met(attempt.target, tried.seen_in)
                return replace(tried, outcome=Outcome.DELIVERED) if is_there else tried
            first = first or tried
            if not tried.has_way_out:
                break
        return first or replace(attempt, outcome=Outcome.NO_PLAN, reason="no bin is large enough for it")

    def _planned(self, attempt: Attempt, scene: Scene) -> Attempt:
        """Plan with a kind of grasp that has not failed, else with another grasp of a kind that has."""
        if not self.runner.has_time_to_plan:
            return replace(attempt, outcome=Outcome.NO_TIME, reason=NO_TIME_TO_PLAN)
        self.runner.say(attempt, "planning")
        in_vain = self.in_vain.get(attempt.item, ())
        kinds = tuple(dict.fromkeys(GraspKind(grasp.kind, grasp.face) for grasp in in_vain))
        if kinds:
            found = self.runner.planned(attempt, scene, (*in_vain, *kinds))
            if found.plan is not None or not self.runner.has_time_to_plan:
                return found
            attempt = replace(attempt, rejected=found.rejected)
            in_vain = (*in_vain, *(plan.grasp for plan in found.rejected if plan.grasp is not None))
        return self.runner.planned(attempt, scene, in_vain)

    def _note(self, state: TargetState, attempt: Attempt) -> None:
        """Record an attempt and update the outcomes."""
        self.attempts.append((state, attempt))
        self.toppling.note(attempt)
        self.after_attempt(partial(self.result, self.runner.last_scene))
        self.open[state.index] = state
        if attempt.plan is None:
            is_stuck = attempt.is_aside or not attempt.has_way_out
            if is_stuck and not attempt.topples and attempt.outcome in (Outcome.NO_PLAN, Outcome.REJECTED):
                self._stuck_in(self.runner.last_scene)[attempt.item] = attempt
            return
        # An early contact shows a wrong pose of the item, not a bad grasp.
        is_early = attempt.execution is not None and attempt.execution.stop_cause is StopCause.EARLY_CONTACT
        is_there = attempt.outcome.is_delivered or attempt.outcome is Outcome.MOVED
        if attempt.plan.grasp is not None and not is_there and not is_early:
            self.in_vain[attempt.item] = (*self.in_vain.get(attempt.item, ()), attempt.plan.grasp)
        if attempt.execution is None:
            return
        if not attempt.is_aside:
            self.outcomes.note(state.target, attempt.outcome.is_delivered)
            self.delivered |= {attempt.item} if attempt.outcome.is_delivered else set()
            self.open[state.index] = state.timed(attempt.plan.trajectory.duration)
        # Items may have moved in every place that the tool reached into or that the item was in.
        touched = {attempt.out_of, attempt.into, attempt.seen_in}
        for index, other in self.open.items():
            if touched & {placed.location for placed in self._copies(self.runner.scene(), other)}:
                self.open[index] = other.renewed(is_doubted=not self._may_help(attempt, index))

    def _may_help(self, attempt: Attempt, index: int) -> bool:
        """Whether an attempt moved what a failed plan for another target blamed, or there was none."""
        if index not in self.refused or attempt.plan is None:
            return True
        _, item, blamed = self.refused[index]
        pushed = {name for segment in attempt.plan.segments for name in segment.pushing}
        return bool({attempt.item, *pushed} & {item, *blamed})

    def clear(self, index: int) -> bool:
        """Move one item aside that blocks a target; return whether the target may be tried again."""
        state, scene = self.open[index], self.runner.scene()
        self.open[state.index] = replace(state, clearings=state.clearings + 1)
        placed = self._choose_copy(scene, state)
        if placed is None:
            return False
        wanted = Attempt(
            state.target,
            placed.id,
            state.attempts,
            self.runner.clock.now,
            Outcome.NO_PLAN,
            out_of=placed.location,
        )
        if self._make_room(state, placed, scene):
            return True
        self.runner.say(wanted, "looking for what is in the way")
        wanted = self.runner.ranked(wanted, scene)
        clearing = Clearing(self.runner, wanted, scene, self.tools, self.in_vain.get(placed.id, ()))
        known = self.refused.get(state.index)
        blamed = known[2] if known is not None and known[0] is scene and known[1] == placed.id else None
        clearing.blame(state.clearings > 0, blamed)
        if clearing.is_reachable:  # perceived again since the last failure: pick by the new poses
            self.open[state.index] = replace(self.open[state.index], refusals=0)
            return True
        while self.runner.has_time_to_plan and (name := clearing.next_item()) is not None:
            if (stuck := self._stuck_in(scene).get(name)) is not None:  # the same query would fail again
                clearing.also(stuck.in_the_way)
                continue
            blocker = scene.find(name)
            if any(self._make_room(other, blocker, scene) for other in self._targets_of(blocker, scene)):
                return True
            aside = self._moved_aside(replace(wanted, item=name, is_aside=True), scene)
            self._note(self.open[state.index], aside)
            is_toppled = aside.execution is None and self._topple(self.open[state.index], name)
            if aside.execution is not None or is_toppled:  # the scene has changed
                self.open[state.index] = replace(self.open[state.index], cleared=state.cleared + 1)
                return True
            clearing.also(aside.in_the_way)
        return False

    def _targets_of(self, placed: PlacedItem, scene: Scene) -> tuple[TargetState, ...]:
        """Open targets that an item could fulfil."""
        return tuple(state for state in self.open.values() if placed in self._copies(scene, state))

    def _make_room(self, state: TargetState, placed: PlacedItem, scene: Scene) -> bool:
        """Move an item of a bin elsewhere if that is all that keeps one of the tote from being stowed."""
        tried = (attempt for other, attempt in reversed(self.attempts) if other.index == state.index)
        last = next((attempt for attempt in tried if not attempt.is_aside), None)
        lacks_room = last is not None and last.plan is None and last.has_way_out
        in_bins = frozenset((p.id, p.location) for p in scene.items if p.location != TOTE)
        if state.target.into != ANY_BIN or not lacks_room or self.no_room.get(placed.id) == in_bins:
            return False
        now = self.runner.clock.now
        attempt = Attempt(state.target, placed.id, state.attempts, now, Outcome.NO_PLAN, out_of=TOTE)
        self.runner.say(attempt, "looking for room in a bin")
        bins, exclude = self.bins[state.target.item], self.in_vain.get(placed.id, ())
        wanted = self.runner.ranked(attempt, scene)
        for inside in items_in_the_place_of(self.runner, wanted, scene, bins, self.tools, exclude):
            now = self.runner.clock.now
            aside = replace(attempt, item=inside.id, t_start=now, out_of=inside.location, is_aside=True)
            moved = self._moved_into_another_bin(aside, scene, ())
            if moved is not None:
                self._note(state, moved)
                self.open[state.index] = replace(state.renewed(), cleared=state.cleared + 1)
                return True
        self.no_room[placed.id] = in_bins
        return False

    def _moved_into_another_bin(
        self, attempt: Attempt, scene: Scene, still_open: Sequence[Target]
    ) -> Attempt | None:
        """Try to move an item aside into another bin; None if no plan leads there."""
        for into in destinations(scene, attempt.out_of, still_open):
            if not self.runner.has_time_to_plan:
                break
            moved = self._moved(replace(attempt, into=into), scene)
            if moved.plan is not None:
                return moved
        return None

    def _stuck_in(self, scene: Scene) -> dict[str, Attempt]:
        """Failed attempts, by id, at items that cannot leave their place in a scene as perceived once."""
        if self.stuck[0] is not scene:
            self.stuck = (scene, {})
        return self.stuck[1]

    def _moved_aside(self, attempt: Attempt, scene: Scene) -> Attempt:
        """Try to move an item into another bin, or into the tote if none has room.

        An item that cannot be brought into the tote cannot leave its bin, so no other bin is tried. Items to
        be stowed are moved within the tote only, as stowing them has been tried separately.
        """
        attempt = replace(attempt, t_start=self.runner.clock.now)
        out = self._planned(replace(attempt, into=TOTE), scene)
        if out.plan is None:
            return out
        targets = [state.target for state in self.open.values()]
        moved = None if attempt.out_of == TOTE else self._moved_into_another_bin(attempt, scene, targets)
        if moved is not None:
            return moved
        return carry_out(self.runner, out)

    def _choose_copy(self, scene: Scene, state: TargetState) -> PlacedItem | None:
        """Choose the copy of a target nearest to a mouth; on a retry the next one.

        A copy counts for the bin that it was in at the start, even after it has moved.
        """
        copies = from_the_mouth(scene, self._copies(scene, state))
        return copies[max(0, state.attempts - 1) % len(copies)] if copies else None

    def _copies(self, scene: Scene, state: TargetState) -> tuple[PlacedItem, ...]:
        """Items that could fulfil a target, in any place except its destination."""
        return tuple(
            placed
            for placed in scene.items
            if placed.item.name == state.target.item
            and self.homes.get(placed.id) == state.target.bin
            and not self.order.is_met(state.target, placed.location)
            and placed.id not in self.delivered
        )

    def _say(self, attempt: Attempt, doing: str) -> None:
        n_done = len(self.targets) - len(self.open)
        what = f"{attempt.item} aside" if attempt.is_aside else attempt.target.item
        left = f"{self.runner.clock.left:.0f} s left on the trial's clock"
        text = f"{attempt.target.bin} {what}: {doing}, {left}"
        self.on_progress(Progress(n_done, len(self.targets), text))

    def result(self, belief: Scene) -> TrialResult:
        """Return all results, with the score of the true state; belief: the scene as last perceived."""
        arena, runner = self.interfaces.arena, self.runner
        after = arena.now()
        attempts = tuple(attempt for _, attempt in self.attempts)
        executions = [e for attempt in attempts for e in attempt.executions]
        disturbed_last = arena.disturbed()
        disturbed = [*(d for e in executions for d in e.disturbed), *disturbed_last]
        fallen = (Drop(d.item, d.fell) for d in disturbed if d.kind is DisturbanceKind.FELL)
        drops = (*(d for e in executions for d in e.drops), *fallen)
        is_judged = self.settings.reality.damage_limits
        hit = damages(self.before, arena.collisions) if is_judged else ()
        final = final_state(self.order, self.before, after, belief, arena.held, drops, hit)
        points = score(self.order, final, self.bonus)
        return TrialResult(
            order=self.order,
            seed=self.settings.seed,
            noise=self.settings.noise,
            reality=self.settings.reality,
            targets=tuple(self._target_result(state, points) for state in self.targets),
            attempts=attempts,
            before=self.before,
            after=after,
            final=final,
            score=points,
            collisions=arena.collisions,
            simulated=runner.clock.simulated,
            clock=runner.clock.now,
            aborted=runner.stuck,
            cut_short=runner.cut_short,
            disturbed_last=disturbed_last,
            strategy=self.settings.strategy.name,
            strategy_hash=self.settings.strategy.digest,
            ticks=tuple(self.player.ticks),
            strategy_stuck=self.player.stuck,
        )

    def _target_result(self, state: TargetState, score: Score) -> TargetResult:
        own = tuple(attempt for j, attempt in self.attempts if j.index == state.index)
        picks = [attempt for attempt in own if not attempt.is_aside]
        points = score.lines[state.index].points  # the lines of the targets come first, in their order
        if not picks:
            outcome, why = Outcome.NOT_TRIED, "the strategy made no attempt"
            if not self.runner.has_time_to_plan:
                outcome, why = Outcome.NO_TIME, "the time was over"
            return TargetResult(state.target, outcome, why, points, own)
        attempted = (a for a in reversed(picks) if a.outcome is not Outcome.NO_TIME or a.executions)
        last = next(attempted, picks[-1])
        return TargetResult(state.target, last.outcome, last.reason, points, own)
