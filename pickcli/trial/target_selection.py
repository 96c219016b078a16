"""What to do next: the attempt that promises most points per second, while there is something new to try.

Delft retried failed picks for ever, at the end, and moved away what hid a target. Here a chance is kept for
every target: it starts from a prior, falls with every attempt in vain, and learns from what happened to that
item and in the same bin. What failed is tried again only where something about it is new: another grasp, a
scene that has changed, or another look at one that has not.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

from pickcli.cell.cell import Cell
from pickcli.cell.tool import Tool
from pickcli.grasping.method_choice import may_hold
from pickcli.trial.order import ANY_BIN, Order, OrderKind, Target
from pickcli.trial.score import target_points

PICK_SECONDS = 12.0  # of an item of which no plan is known yet: the figure to reach, leaving to released
TIME_LIMIT = {2015: 20 * 60.0, 2016: 15 * 60.0}  # s
MOVE_TIME = 60.0  # s for each of an order's moves, which no rules limit
PLANNING_CHARGE = 1.5  # s per planning call: at most 0.5 s of planning and 1 s of verification

PRIOR = 4.0  # successes that every item and every bin starts with
RETRY_CHANCE = 0.5  # by which each attempt in vain at one target lowers the chance of the next
AGAIN_CHANCE = 0.2  # of a plan where another look found none: the error of the poses is another one
HIDING = 0.03  # of a move to where other targets wait, which it hides: three looks at each of them come first
CLEAR_CHANCE = 0.5  # that moving something aside helps
CLEAR_CALLS = 4  # planning calls that finding out what is in the way takes, about

MOST_FAILURES = 8  # motions in vain for one target
MOST_REFUSALS = 12  # looks at one unchanged scene that may lead to no plan
MOST_CLEARED = 8  # items that are moved aside for one target
MOST_CLEARINGS = 4  # looks at one unchanged scene with nothing found that could be moved


class Move(StrEnum):
    """What can be done for a target."""

    PICK = "pick"
    CLEAR = "clear"  # move something aside that is in its way


@dataclass(frozen=True)
class TargetState:
    """One target and what is known of it. It is replaced, never changed.

    Attributes:
        index: Place in the work order, which breaks ties.
        target: What is to be picked, and from where.
        points: What the item gives where it is wanted, at most.
        seconds: Estimated duration of the next attempt.
        can_hold: Whether a tool can hold it at all; what it cannot hold is asked for once, at the end.
        attempts: Attempts so far, whatever became of them.
        failures: Motions in vain.
        cleared: Motions by which something was moved aside for it, or should have been.
        refusals: Looks at the scene as it is now that led to no plan.
        clearings: Looks at the scene as it is now in which nothing was found that could be moved aside.
    """

    index: int
    target: Target
    points: int
    seconds: float
    can_hold: bool = True
    attempts: int = 0
    failures: int = 0
    cleared: int = 0
    refusals: int = 0
    clearings: int = 0

    def tried(self) -> TargetState:
        """Count one more attempt.

        Returns:
            The target after it.
        """
        return replace(self, attempts=self.attempts + 1)

    def timed(self, seconds: float) -> TargetState:
        """Put the duration of a plan for it in place of the estimate.

        Args:
            seconds: Duration of the plan, s.

        Returns:
            The target with it.
        """
        return replace(self, seconds=seconds)

    def failed(self) -> TargetState:
        """Count one more motion in vain.

        Returns:
            The target after it.
        """
        return replace(self, failures=self.failures + 1)

    def refused(self) -> TargetState:
        """Count one more look that led to no plan.

        Returns:
            The target after it.
        """
        return replace(self, refusals=self.refusals + 1)

    def renewed(self) -> TargetState:
        """Forget the looks at a scene that has changed where it matters.

        Returns:
            The target in the new scene.
        """
        return replace(self, refusals=0, clearings=0)

    @property
    def can_pick(self) -> bool:
        """Whether another attempt could end otherwise than the last."""
        if not self.can_hold:
            return self.attempts == 0
        return self.failures < MOST_FAILURES and self.refusals < MOST_REFUSALS

    @property
    def can_clear(self) -> bool:
        """Whether it is known that it cannot be picked as it lies, and something might be moved aside."""
        is_open = self.cleared < MOST_CLEARED and self.clearings < MOST_CLEARINGS
        return self.can_hold and self.refusals > 0 and self.failures < MOST_FAILURES and is_open


@dataclass
class Experience:
    """How often executed attempts at an item, and in a bin, went well and ill in this trial.

    Attributes:
        successes: Number of attempts that went well, by name of the item and by name of the bin.
        failures: Attempts that failed, by the same keys.
    """

    successes: Counter[str] = field(default_factory=Counter)
    failures: Counter[str] = field(default_factory=Counter)

    def note(self, target: Target, is_success: bool) -> None:
        """Learn from one executed attempt.

        Args:
            target: What was attempted.
            is_success: Whether it went well.
        """
        (self.successes if is_success else self.failures).update((target.item, target.bin))

    def chance(self, target: Target) -> float:
        """Estimate the chance that an attempt goes well, from all that happened to others like it.

        Args:
            target: What would be attempted.

        Returns:
            Chance between 0 and 1.
        """
        shares = [
            (PRIOR + self.successes[name]) / (PRIOR + self.successes[name] + self.failures[name])
            for name in (target.item, target.bin)
        ]
        return shares[0] * shares[1]


@dataclass(frozen=True)
class Option:
    """One thing that could be done next.

    Attributes:
        state: The target that it is done for.
        move: What is done.
        rate: Expected points per second.
    """

    state: TargetState
    move: Move
    rate: float


def options(targets: Iterable[TargetState], experience: Experience, may_clear: bool) -> Iterator[Option]:
    """List all that is worth trying for the open targets.

    Args:
        targets: The open targets.
        experience: What went well and ill so far.
        may_clear: Whether items may be moved aside.

    Yields:
        What could be done next.
    """
    targets = tuple(targets)
    waiting = {state.target.bin for state in targets}
    for state in targets:
        chance = experience.chance(state.target) * RETRY_CHANCE**state.failures if state.can_hold else 0.0
        if state.target.into in waiting:
            chance *= HIDING
        if state.can_pick:
            seen = AGAIN_CHANCE**state.refusals
            yield Option(state, Move.PICK, chance * seen * state.points / (state.seconds + PLANNING_CHARGE))
        if may_clear and state.can_clear:
            seconds = 2 * state.seconds + CLEAR_CALLS * PLANNING_CHARGE
            left = CLEAR_CHANCE ** (1 + state.cleared + state.clearings)
            yield Option(state, Move.CLEAR, chance * left * state.points / seconds)


def best_option(found: Iterable[Option]) -> Option | None:
    """Choose the option with the most points per second; the earlier line of the order where equal.

    Args:
        found: What could be done.

    Returns:
        The option, None if there is none.
    """
    return max(found, key=lambda o: (o.rate, -o.state.index, o.move is Move.PICK), default=None)


def time_limit(order: Order) -> float:
    """How long a trial may take.

    Args:
        order: The order that is played.

    Returns:
        s, by the rules of the order's year; of moves so much for each.
    """
    return MOVE_TIME * len(order.work_order) if order.kind is OrderKind.MOVE else TIME_LIMIT[order.year]


def may_move_others(order: Order) -> bool:
    """Tell whether items that are no targets may go elsewhere.

    Args:
        order: The order that is played.

    Returns:
        Whether they may: in 2015 the rules took 12 points for each, and moves name all that is to be moved.
        In a stow they go elsewhere in the tote.
    """
    return order.kind is OrderKind.STOW or (order.kind is OrderKind.PICK and order.year != 2015)


def target_states(
    order: Order, cell: Cell, bonus: Mapping[str, int], tools: Sequence[Tool]
) -> tuple[TargetState, ...]:
    """Make one target per line of an order; of a stow, one per item in the tote.

    Args:
        order: The order.
        cell: The cell, for its items.
        bonus: Points by name of the item, as from ``item_bonuses``.
        tools: Of every arm.

    Returns:
        The targets, in the order of the lines.
    """
    states = []
    for index, target in enumerate(order.targets):
        item = cell.item(target.item, order.year)
        points = max(target_points(order, name, target.item, bonus) for name in _counting(order, target))
        # Only the second half of a pick carries the item; slow items stretch that half.
        seconds = PICK_SECONDS / 2 * (1.0 + 1.0 / item.speed_scale)
        states.append(TargetState(index, target, points, seconds, can_hold=may_hold(tools, item)))
    return tuple(states)


def _counting(order: Order, target: Target) -> Iterable[str]:
    """Bins whose fill decides what a target is worth: where it is, and of a stow all where it may get."""
    return order.bin_contents if target.into == ANY_BIN else (target.bin,)


@dataclass(frozen=True)
class TrialClock:
    """The clock of a trial: simulated time and a fixed charge per planning call, never wall time.

    Attributes:
        limit: s, when the trial ends.
        simulated: s of simulated time so far.
        n_plans: Number of planning calls so far.
        charge: s per planning call.
    """

    limit: float
    simulated: float = 0.0
    n_plans: int = 0
    charge: float = PLANNING_CHARGE

    @property
    def now(self) -> float:
        """Time since the start of the trial, s."""
        return self.simulated + self.n_plans * self.charge

    @property
    def left(self) -> float:
        """Time until the limit, s; never negative."""
        return max(0.0, self.limit - self.now)

    def planned(self) -> TrialClock:
        """Count one more planning call.

        Returns:
            The clock after it.
        """
        return replace(self, n_plans=self.n_plans + 1)

    def moved(self, seconds: float) -> TrialClock:
        """Let simulated time pass.

        Args:
            seconds: Simulated s.

        Returns:
            The clock after them.
        """
        return replace(self, simulated=self.simulated + seconds)

    def has_time_for(self, seconds: float) -> bool:
        """Tell whether something still ends within the limit.

        Args:
            seconds: How long it takes, s.

        Returns:
            Whether it does.
        """
        return self.now + seconds <= self.limit
