"""Values the possible attempts of a trial by their expected points per second, for its strategy.

Every target has a probability of success, which starts from a prior, decreases with failed attempts, and is
updated by the outcomes for the same item and the same bin. A failed attempt is repeated only with something
new: another grasp, a changed scene, or another look at an unchanged one.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from pickcli.cell.cell import Cell
from pickcli.cell.tool import Tool
from pickcli.grasping.method_choice import may_hold
from pickcli.strategy.node_types import ActionKind
from pickcli.strategy.trial_actions import OpenTarget
from pickcli.trial.order import ANY_BIN, Order, Target
from pickcli.trial.score import target_points
from pickcli.trial.trial_clock import PLANNING_CHARGE

PICK_SECONDS = 12.0  # s for an item without a plan: the target time from start to release

PRIOR_SUCCESSES = 4.0  # successes assumed at the start for every item and every bin
RETRY_CHANCE = 0.5  # factor on the chance for each failed attempt at a target
AGAIN_CHANCE = 0.2  # factor for each look without a plan; another look has other pose errors
HIDING_FACTOR = 0.03  # factor for a move that would hide open targets: about three looks at each come first
CLEAR_CHANCE = 0.5  # probability that moving an item aside helps
CLEAR_CALLS = 4  # typical number of planning calls to find blocking items

MOST_FAILURES = 8  # failed motions for one target
MOST_REFUSALS = 12  # looks at one unchanged scene without a plan
# The same of a stow: in eight of them none of 50 plans was found after the third look at an unchanged heap.
MOST_REFUSALS_OF_STOW = 4
MOST_CLEARED = 8  # items moved aside for one target
MOST_CLEARINGS = 4  # looks at one unchanged scene without a movable blocking item


@dataclass(frozen=True)
class TargetState:
    """State of one target; immutable.

    Attributes:
        index: Position in the work order, which breaks ties.
        target: The item and its place.
        points: Largest number of points of the item at its destination.
        seconds: Estimated duration of the next attempt.
        can_hold: Whether a tool can hold it; otherwise it is tried only once, at the end.
        attempts: Number of attempts so far.
        failures: Number of failed motions.
        cleared: Number of motions, failed or not, to move blocking items aside.
        refusals: Number of looks at the present scene that led to no plan.
        clearings: Number of looks at the present scene without a movable blocking item.
        is_doubted: Whether the last plan failed, and nothing that it blamed has moved since.
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
    is_doubted: bool = False

    def tried(self) -> TargetState:
        """Count one more attempt.

        Returns:
            The target after it.
        """
        return replace(self, attempts=self.attempts + 1, is_doubted=False)

    def timed(self, seconds: float) -> TargetState:
        """Replace the estimated duration by that of a plan.

        Args:
            seconds: Duration of the plan, s.

        Returns:
            The updated target.
        """
        return replace(self, seconds=seconds)

    def failed(self) -> TargetState:
        """Count one more failed motion.

        Returns:
            The target after it.
        """
        return replace(self, failures=self.failures + 1)

    def refused(self) -> TargetState:
        """Count one more look without a plan.

        Returns:
            The target after it.
        """
        return replace(self, refusals=self.refusals + 1)

    def renewed(self, is_doubted: bool = False) -> TargetState:
        """Reset the counts of looks after the relevant part of the scene has changed.

        Args:
            is_doubted: Whether the last plan failed, and nothing that it blamed has moved.

        Returns:
            The updated target.
        """
        return replace(self, refusals=0, clearings=0, is_doubted=is_doubted)

    @property
    def can_pick(self) -> bool:
        """Whether another attempt could have another outcome."""
        if not self.can_hold:
            return self.attempts == 0
        most = MOST_REFUSALS_OF_STOW if self.target.into == ANY_BIN else MOST_REFUSALS
        return self.failures < MOST_FAILURES and self.refusals < most

    @property
    def can_clear(self) -> bool:
        """Whether planning failed in the present scene, and blocking items may still be moved."""
        is_open = self.cleared < MOST_CLEARED and self.clearings < MOST_CLEARINGS
        return self.can_hold and self.refusals > 0 and self.failures < MOST_FAILURES and is_open


@dataclass
class AttemptOutcomes:
    """Outcomes of executed attempts in this trial, by item and by bin.

    Attributes:
        successes: Number of successful attempts, by name of the item and by name of the bin.
        failures: Attempts that failed, by the same keys.
    """

    successes: Counter[str] = field(default_factory=Counter)
    failures: Counter[str] = field(default_factory=Counter)

    def note(self, target: Target, is_success: bool) -> None:
        """Record the outcome of an executed attempt.

        Args:
            target: The target of the attempt.
            is_success: Whether it succeeded.
        """
        (self.successes if is_success else self.failures).update((target.item, target.bin))

    def chance(self, target: Target) -> float:
        """Estimate the probability of success from the outcomes for the same item and the same bin.

        Args:
            target: The target of the attempt.

        Returns:
            Probability, 0 to 1.
        """
        shares = [
            (PRIOR_SUCCESSES + self.successes[name])
            / (PRIOR_SUCCESSES + self.successes[name] + self.failures[name])
            for name in (target.item, target.bin)
        ]
        return shares[0] * shares[1]


def open_targets(
    targets: Iterable[TargetState], outcomes: AttemptOutcomes, may_clear: bool, n_items: Mapping[str, int]
) -> tuple[OpenTarget, ...]:
    """List the targets for which something is worth trying, with the value of each possible action.

    Args:
        targets: All targets that are not done.
        outcomes: Outcomes so far.
        may_clear: Whether items may be moved aside.
        n_items: Number of perceived items by place; places without any are left out.

    Returns:
        The targets, in the order of the lines.
    """
    targets = tuple(targets)
    waiting = {state.target.bin for state in targets}
    found = []
    for state in sorted(targets, key=lambda state: state.index):
        chance = outcomes.chance(state.target) * RETRY_CHANCE**state.failures if state.can_hold else 0.0
        if state.target.into in waiting:
            chance *= HIDING_FACTOR
        if state.is_doubted:
            chance *= AGAIN_CHANCE
        rates = {}
        if state.can_pick:
            seconds = state.seconds + PLANNING_CHARGE
            rates[ActionKind.PICK] = chance * AGAIN_CHANCE**state.refusals * state.points / seconds
        if may_clear and state.can_clear:
            seconds = 2 * state.seconds + CLEAR_CALLS * PLANNING_CHARGE
            left = CLEAR_CHANCE ** (1 + state.cleared + state.clearings)
            rates[ActionKind.CLEAR] = chance * left * state.points / seconds
        if rates:
            here = n_items.get(state.target.bin, 0)
            found.append(_open_target(state, here, rates))
    return tuple(found)


def _open_target(state: TargetState, n_items: int, rates: Mapping[ActionKind, float]) -> OpenTarget:
    item, place = state.target.item, state.target.bin
    is_refused = state.refusals > 0
    return OpenTarget(state.index, item, place, state.points, state.attempts, n_items, is_refused, rates)


def target_states(
    order: Order, cell: Cell, bonus: Mapping[str, int], tools: Sequence[Tool]
) -> tuple[TargetState, ...]:
    """Create one target per line of an order; for a stow, one per item in the tote.

    Args:
        order: The order.
        cell: The cell, for its items.
        bonus: Points by name of the item, as from ``item_bonuses``.
        tools: Tools of all arms.

    Returns:
        The targets, in the order of the lines.
    """
    states = []
    for index, target in enumerate(order.targets):
        item = cell.item(target.item, order.year)
        points = max(target_points(order, name, target.item, bonus) for name in _counting(order, target))
        # Only the second half of a pick carries the item, so slow items extend only that half.
        seconds = PICK_SECONDS / 2 * (1.0 + 1.0 / item.speed_scale)
        states.append(TargetState(index, target, points, seconds, can_hold=may_hold(tools, item)))
    return tuple(states)


def _counting(order: Order, target: Target) -> Iterable[str]:
    """Bins whose contents determine a target's points: its own, or for a stow all possible destinations."""
    return order.bin_contents if target.into == ANY_BIN else (target.bin,)
