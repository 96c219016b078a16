"""Plays a whole trial by a strategy, until all targets are done, the strategy ends or time is over.

Randomness depends only on the seed, and time only on simulated time and the number of planning calls: two
runs of a trial differ only in ``statistics``.
"""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TypeAlias

from pickcli.grasping.method_choice import may_hold
from pickcli.progress import Progress, ProgressObserver, nobody
from pickcli.scene.scene import TOTE, PlacedItem, Scene
from pickcli.statics.unrecognised import NOT_RECOGNISED
from pickcli.strategy.name_check import unknown_names
from pickcli.strategy.strategy_player import StrategyPlayer
from pickcli.strategy.trial_actions import OpenTarget
from pickcli.trial.action_values import TargetState, target_states
from pickcli.trial.aside_memory import AsideMemory
from pickcli.trial.attempt_memory import AttemptMemory
from pickcli.trial.attempt_runner import AttemptRunner
from pickcli.trial.clearing import Clearing
from pickcli.trial.damage import damages
from pickcli.trial.disturbance import DisturbanceKind
from pickcli.trial.final_state import Drop, final_state
from pickcli.trial.item_moves import ItemMoves
from pickcli.trial.order import ANY_BIN, Order, OrderKind, require_playable, time_limit
from pickcli.trial.room_making import RoomMaking
from pickcli.trial.score import Score, item_bonuses, score, target_points, told_by_copies
from pickcli.trial.stow_assignment import assign_bins
from pickcli.trial.target_list import TargetList
from pickcli.trial.toppling_memory import TopplingMemory
from pickcli.trial.trial_interfaces import TrialInterfaces
from pickcli.trial.trial_result import Attempt, Outcome, TargetResult, TrialResult
from pickcli.trial.trial_settings import TrialSettings

ResultObserver: TypeAlias = Callable[[Callable[[], TrialResult]], None]

MOST_WRONG = 2  # attempts at a target in which another item was held, after which it is given up
# An exchange for points is tried only with so much time left: for itself, and for every open target.
EXCHANGE_TIME, TARGET_TIME = 30.0, 35.0  # s
MOST_EXCHANGES = 3  # for one target
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

    bins: of a stow, by item name the bins to try, in this order
    attempts: all attempts in order of time, each with the state of its target before
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
        limit = time_limit(order) if settings.time_limit is None else settings.time_limit
        self.tools = [each.robot.tool for each in (interfaces.cells or {"": cell}).values()]
        states = target_states(order, cell, self.bonus, self.tools)
        self.on_progress(Progress(0, len(states), "looking into all places"))
        self.runner = AttemptRunner(interfaces, settings, limit, self._say)
        self.bins: dict[str, tuple[str, ...]] = {}
        if order.kind is OrderKind.STOW:
            choices = assign_bins(order, cell, self.bonus, self.tools, settings.stow_rule)
            self.bins = {choice.item: choice.bins for choice in choices}
        self.targets = TargetList(order, states, self.runner.perception.homes(self.runner.last_scene))
        self.memory = AttemptMemory()
        self.toppling = TopplingMemory(any(tool.pushing_state is not None for tool in self.tools))
        self.asides = AsideMemory(self.targets)
        self.moves = ItemMoves(order, self.runner, self.memory, self.asides, self.bins)
        self.room = RoomMaking(self.runner, self.moves, self.tools)
        self.n_exchanges: Counter[int] = Counter()  # by index of a target
        self.attempts: list[tuple[TargetState, Attempt]] = []
        self.player = StrategyPlayer(settings.strategy, self)
        names = {name for name, _ in cell.items} | {placed.item.name for placed in self.before.items}
        for line in unknown_names(settings.strategy, names, cell.places):
            _log.warning("strategy %s: %s", settings.strategy.name, line)

    def play(self) -> None:
        """Tick the strategy until nothing is left that it would try, or time is over."""
        self.player.play()
        n_targets = len(self.targets.states)
        self.on_progress(Progress(n_targets, n_targets, "done"))

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
        return self.targets.valued(self.runner.last_scene)

    def look(self) -> bool:
        """Look again; every look has different errors. False if there is no time."""
        return self.runner.look_again()

    def so_far(self) -> str:
        """Describe what an interrupted trial loses, and how to repeat it."""
        n_in = sum(attempt.outcome.is_delivered for _, attempt in self.attempts)
        where = "in the tote" if self.order.kind is OrderKind.PICK else "delivered"
        n_targets = len(self.targets.states)
        played = f"{n_in} of {n_targets} targets were {where} after {len(self.attempts)} attempts"
        return f"{played}; a trial cannot be continued: the same command plays it again from the start"

    def give_up(self, index: int) -> None:
        """Close a target."""
        self.targets.close(index)

    def pick(self, index: int) -> bool:
        """Make one attempt at a target, and update its state; return whether it is delivered."""
        state = self.targets.open[index].tried()
        attempt = self._attempt(state)
        self._note(state, attempt)
        if attempt.is_aside:  # made room for the target
            self.targets.put(replace(state.renewed(), cleared=state.cleared + 1))
            return False
        is_over = attempt.outcome in (Outcome.MISSING, Outcome.NO_TIME) or self._is_mistaken(index)
        if attempt.outcome.is_delivered or is_over:
            self.targets.close(index)
        elif attempt.execution is None:
            refused = self.targets.put(self.targets.open[index].refused())
            if attempt.outcome in (Outcome.NO_PLAN, Outcome.REJECTED):
                self.memory.refuse(index, attempt, self.runner.scene())
                for name in (attempt.item, *attempt.in_the_way):
                    if self._topple(refused, name):
                        break
        else:
            self.targets.put(self.targets.open[index].failed())
        return attempt.outcome.is_delivered

    def _is_mistaken(self, index: int) -> bool:
        """Whether what is taken for a target turned out to be another item in two attempts."""
        outcomes = [attempt.outcome for state, attempt in self.attempts if state.index == index]
        return outcomes.count(Outcome.WRONG_ITEM) >= MOST_WRONG

    def clear(self, index: int) -> bool:
        """Move one item aside that blocks a target; return whether the target may be tried again."""
        state, scene = self.targets.open[index], self.runner.scene()
        self.targets.put(replace(state, clearings=state.clearings + 1))
        placed = self.targets.chosen_copy(scene, state)
        if placed is None:
            is_there = bool(self.runner.perception.refusal(state.target.item, state.target.bin))
            return is_there and self._uncover(state, scene, state.target.bin)
        now = self.runner.clock.now
        wanted = Attempt(
            state.target, placed.id, state.attempts, now, Outcome.NO_PLAN, out_of=placed.location
        )
        if self._make_room(state, placed, scene):
            return True
        self.runner.say(wanted, "looking for what is in the way")
        wanted = self.runner.ranked(wanted, scene)
        exclude = self.memory.failed_grasps(placed.id)
        clearing = Clearing(self.runner, wanted, scene, self.tools, exclude)
        clearing.blame(state.clearings > 0, self.memory.blamed(index, placed.id, scene))
        clearing.also(self.toppling.blocking.get(placed.id, ()))
        if clearing.is_reachable:  # perceived again since the last failure: pick by the new poses
            self.targets.put(replace(self.targets.open[index], refusals=0))
            return True
        while self.runner.has_time_to_plan and (name := clearing.next_item()) is not None:
            if (stuck := self.memory.stuck(name, scene)) is not None:  # the same query would fail again
                clearing.also(stuck.in_the_way)
                continue
            blocker = scene.find(name)
            others = self.targets.fulfilled_by(blocker, scene)
            if any(self._make_room(other, blocker, scene) for other in others):
                return True
            if self._stow_blocker(blocker, scene):
                return True
            if self.asides.would_repeat(name, blocker.location, scene):
                continue
            still_open = [other.target for other in self.targets.open.values()]
            aside = self.moves.move_aside(replace(wanted, item=name, is_aside=True), scene, still_open)
            self._note(self.targets.open[index], aside)
            is_toppled = aside.execution is None and self._topple(self.targets.open[index], name)
            if aside.execution is not None or is_toppled:  # the scene has changed
                self.targets.put(replace(self.targets.open[index], cleared=state.cleared + 1))
                return True
            clearing.also(aside.in_the_way)
        return self._touches_unrecognised(state) and self._uncover(state, scene, placed.location, placed.id)

    def _touches_unrecognised(self, state: TargetState) -> bool:
        """Whether a target was refused last as something that nobody recognised may rest or lean on it."""
        tried = (attempt for other, attempt in reversed(self.attempts) if other.index == state.index)
        last = next((attempt for attempt in tried if not attempt.is_aside), None)
        return last is not None and any(reason.what == NOT_RECOGNISED for reason in last.reasons)

    def _uncover(self, state: TargetState, scene: Scene, place: str, wanted: str = "") -> bool:
        """Move aside what hides most of the place of a target; return whether something was moved.

        What no look shows, or not surely enough, is behind what is recognised: the place is looked into again
        without that.
        """
        target = state.target
        for name in self.runner.perception.hiding(place):
            if name == wanted or not self.runner.has_time_to_plan:
                continue
            hiding = scene.find(name)
            is_known = self.memory.stuck(name, scene) is not None  # the same query would fail again
            if is_known or self.asides.would_repeat(name, hiding.location, scene):
                continue
            if not may_hold(self.tools, hiding.item) or self.targets.fulfilled_by(hiding, scene):
                continue  # another target is tried for itself
            attempt = Attempt(
                target, name, state.attempts, self.runner.clock.now, Outcome.NO_PLAN,
                is_aside=True, out_of=hiding.location,
            )  # fmt: skip
            still_open = [other.target for other in self.targets.open.values()]
            aside = self.moves.move_aside(attempt, scene, still_open)
            self._note(self.targets.open[state.index], aside)
            if aside.execution is not None:  # the scene has changed
                self.targets.put(replace(state.renewed(), cleared=state.cleared + 1))
                return True
        return False

    def _stow_blocker(self, blocker: PlacedItem, scene: Scene) -> bool:
        """Stow an item of the tote that is in the way of another, if it may be; return whether it was moved.

        The last refusal may have been that of another look. No query is asked twice in a scene as perceived
        once.
        """
        state = next((o for o in self.targets.fulfilled_by(blocker, scene) if o.target.into == ANY_BIN), None)
        if state is None or self.targets.chosen_copy(scene, state) is not blocker:
            return False
        if self.memory.blamed(state.index, blocker.id, scene) is not None:
            return False
        n_played = self._n_played
        self.pick(state.index)
        return self._n_played > n_played

    @property
    def _n_played(self) -> int:
        return sum(attempt.execution is not None for _, attempt in self.attempts)

    def _attempt(self, state: TargetState) -> Attempt:
        """Play an attempt at a target to its end."""
        scene = self.runner.scene()
        now, into = self.runner.clock.now, state.target.into
        attempt = Attempt(state.target, "", state.attempts, now, Outcome.MISSING, into=into)
        placed = self.targets.chosen_copy(scene, state)
        if placed is None:
            item, home = state.target.item, state.target.bin
            if refusal := self.runner.perception.refusal(item, home):
                return replace(attempt, outcome=Outcome.NOT_RECOGNISED, reason=refusal)
            return replace(attempt, reason=f"no {item} of {home} is seen any more")
        attempt = replace(attempt, item=placed.id, out_of=placed.location)
        return self.moves.move(attempt, scene, partial(self._exchange, state, scene))

    def _exchange(self, state: TargetState, scene: Scene, planned: Attempt) -> Attempt | None:
        """Make room for an item of the tote in a bin in which it gives more points than in that of its plan.

        Only what was in a bin at the start is moved, and only if time is left for all that is still open.
        """
        needed = EXCHANGE_TIME + TARGET_TIME * len(self.targets.open)
        is_over = self.n_exchanges[state.index] >= MOST_EXCHANGES or self.runner.clock.left < needed
        if state.target.into != ANY_BIN or is_over:
            return None

        def points(name: str) -> int:
            return target_points(self.order, name, state.target.item, self.bonus)

        bins = [name for name in self.bins[state.target.item] if points(name) > points(planned.into)]
        at_start = {placed.id for placed in self.before.items if placed.location != TOTE}
        bins.sort(key=points, reverse=True)
        now = self.runner.clock.now
        attempt = Attempt(state.target, planned.item, state.attempts, now, Outcome.NO_PLAN, out_of=TOTE)
        exclude = self.memory.failed_grasps(planned.item)
        moved = self.room.exchange(attempt, scene, bins, at_start, exclude)
        self.n_exchanges[state.index] += moved is not None
        return moved

    def _topple(self, state: TargetState, name: str) -> bool:
        """Push an item that no tool can take as it lies over or off others; return whether it was pushed."""
        scene = self.runner.scene()
        placed = next((placed for placed in scene.items if placed.id == name), None)
        if placed is None or not self.runner.has_time_to_plan:
            return False
        place, can_be_held = scene.cell.places[placed.location], may_hold(self.tools, placed.item)
        is_target = placed.item.name == state.target.item
        if (is_target and not can_be_held) or not self.toppling.is_due(placed, place, can_be_held):
            return False  # what no tool holds is pushed out of the way of others, and never for itself
        attempt = Attempt(
            state.target, name, state.attempts, self.runner.clock.now, Outcome.NO_PLAN,
            into=placed.location, out_of=placed.location, is_aside=True, topples=True,
        )  # fmt: skip
        toppled = self.moves.topple(attempt, scene)
        self._note(state, toppled)
        return toppled.execution is not None

    def _make_room(self, state: TargetState, placed: PlacedItem, scene: Scene) -> bool:
        """Make room in a bin if that is all that keeps an item of the tote from being stowed."""
        tried = (attempt for other, attempt in reversed(self.attempts) if other.index == state.index)
        last = next((attempt for attempt in tried if not attempt.is_aside), None)
        lacks_room = last is not None and last.plan is None and last.has_way_out
        if state.target.into != ANY_BIN or not lacks_room:
            return False
        now = self.runner.clock.now
        attempt = Attempt(state.target, placed.id, state.attempts, now, Outcome.NO_PLAN, out_of=TOTE)
        bins, exclude = self.bins[state.target.item], self.memory.failed_grasps(placed.id)
        moved = self.room.make_room(attempt, scene, bins, exclude)
        if moved is None:
            return False
        self._note(state, moved)
        self.targets.put(replace(state.renewed(), cleared=state.cleared + 1))
        return True

    def _note(self, state: TargetState, attempt: Attempt) -> None:
        """Record an attempt and update all that is known."""
        self.attempts.append((state, attempt))
        self.toppling.note(attempt)
        self.memory.note(attempt, self.runner.last_scene)
        self.asides.note(state.index, attempt, self.runner.last_scene)
        self.after_attempt(partial(self.result, self.runner.last_scene))
        self.targets.put(state)
        if attempt.plan is None or attempt.execution is None:
            return
        if not attempt.is_aside:
            self.targets.note(state, attempt)
        # Items may have moved in every place that the tool reached into or that the item was in.
        touched = {attempt.out_of, attempt.into, attempt.seen_in}
        for other in self.targets.waiting_in(touched, self.runner.scene()):
            self.targets.put(other.renewed(is_doubted=not self.memory.may_help(attempt, other.index)))

    def _say(self, attempt: Attempt, doing: str) -> None:
        what = f"{attempt.item} aside" if attempt.is_aside else attempt.target.item
        left = f"{self.runner.clock.left:.0f} s left on the trial's clock"
        text = f"{attempt.target.bin} {what}: {doing}, {left}"
        self.on_progress(Progress(self.targets.n_done, len(self.targets.states), text))

    def result(self, belief: Scene) -> TrialResult:
        """Return all results, with the score of the true state; belief: the scene as last perceived."""
        arena, runner = self.interfaces.arena, self.runner
        after = arena.now()
        attempts = tuple(attempt for _, attempt in self.attempts)
        executions = [e for attempt in attempts for e in attempt.executions]
        executions += [e for look in runner.perception.looks for e in look.motions]
        disturbed_last = arena.disturbed()
        disturbed = [*(d for e in executions for d in e.disturbed), *disturbed_last]
        fallen = (Drop(d.item, d.fell) for d in disturbed if d.kind is DisturbanceKind.FELL)
        drops = (*(d for e in executions for d in e.drops), *fallen)
        is_judged = self.settings.reality.damage_limits
        hit = damages(self.before, arena.collisions) if is_judged else ()
        belief = runner.perception.claimed(belief)
        final = final_state(self.order, self.before, after, belief, arena.held, drops, hit)
        delivered = {s.index: a.item for s, a in self.attempts if a.outcome.is_delivered and not a.is_aside}
        targets = [state.target for state in self.targets.states]
        points = told_by_copies(score(self.order, final, self.bonus), targets, delivered)
        return TrialResult(
            order=self.order,
            seed=self.settings.seed,
            noise=self.settings.noise,
            reality=self.settings.reality,
            targets=tuple(self._target_result(state, points) for state in self.targets.states),
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
            perception=self.settings.perception,
            sift=self.settings.sift,
            looks=runner.perception.looks,
            tote=runner.tote,
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
