"""Plays a strategy in a trial of an order: ticks its tree until it fails."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, cast

from pickcli.strategy.node_types import ActionKind
from pickcli.strategy.strategy_tree import Argument, Strategy
from pickcli.strategy.target_choice import best_action, first_target
from pickcli.strategy.tree_player import Tick, TreePlayer
from pickcli.strategy.trial_actions import OpenTarget, TrialActions

SAME_TIME = 1e-6  # s
MAX_IDLE_TICKS = 100  # ticks of the tree in which it does nothing but look, after which it ends


class StrategyPlayer:
    """Ticks a strategy in a trial.

    Args:
        strategy: The strategy.
        actions: The trial.

    Attributes:
        stuck: Why the strategy was ended before its tree failed; "" if it was not.
    """

    def __init__(self, strategy: Strategy, actions: TrialActions) -> None:
        self.stuck = ""
        self._actions = actions
        self._choice = _Choice(actions)
        self._tree = TreePlayer(strategy.root, self._choice)
        self._n_idle = 0

    @property
    def ticks(self) -> list[Tick]:
        """All ticks of conditions and actions so far."""
        return self._tree.ticks

    def play(self) -> None:
        """Tick the tree until it fails, which is the end of the trial."""
        while self.tick():
            pass

    def tick(self) -> bool:
        """Tick the tree once.

        Returns:
            Whether there is more to do: the tree did not fail, and something was done in its last ticks.
        """
        before, n_before = self._time_not_looking(), len(self._actions.open_targets())
        if self._tree.tick() is False:
            return False
        is_idle = (
            self._time_not_looking() - before < SAME_TIME and len(self._actions.open_targets()) == n_before
        )
        self._n_idle = self._n_idle + 1 if is_idle else 0
        if self._n_idle >= MAX_IDLE_TICKS:
            self.stuck = (
                f"the trial was ended early: the strategy tried nothing in {MAX_IDLE_TICKS} ticks; let its "
                "tree fail if nothing is left"
            )
        return not self.stuck

    def _time_not_looking(self) -> float:
        return self._actions.now - self._choice.looked


@dataclass(eq=False)
class _Choice:
    """The trial, and what was chosen last: a target, and an action if one was chosen with it.

    looked: s on the trial's clock that looks have taken
    """

    actions: TrialActions
    index: int | None = None
    action: ActionKind | None = None
    looked: float = 0.0

    @property
    def now(self) -> float:
        """Time on the trial's clock, s."""
        return self.actions.now

    @property
    def time_left(self) -> float:
        """Time until the end of the trial, s."""
        return self.actions.time_left

    def run(self, name: str, arguments: Mapping[str, Argument]) -> tuple[bool, str]:
        """Carry out a condition or an action; return its success, and the target."""
        index, before = self.index, self.target
        is_success = bool(self.leaves()[name](**arguments))
        target = self.target or (before if self.index == index else None)
        return is_success, "" if target is None else str(target)

    @property
    def target(self) -> OpenTarget | None:
        """The chosen target; None if none is chosen, or nothing can be tried for it any more."""
        return next((t for t in self.actions.open_targets() if t.index == self.index), None)

    def choose(self, target: OpenTarget | None, action: ActionKind | None = None) -> bool:
        self.index, self.action = (None if target is None else target.index), action
        return target is not None

    def choose_action(self) -> bool:
        best = best_action(self.actions.open_targets())
        return self.choose(None) if best is None else self.choose(*best)

    def choose_target(self, **arguments: Any) -> bool:
        return self.choose(first_target(self.actions.open_targets(), **arguments))

    def is_action(self, kind: str) -> bool:
        return self.action == kind

    def has_no_plan(self) -> bool:
        return self.target is not None and self.target.has_no_plan

    def attempts_below(self, count: int) -> bool:
        return self.target is not None and self.target.n_attempts < count

    def look(self) -> bool:
        began = self.actions.now
        has_looked = self.actions.look()
        self.looked += self.actions.now - began
        return has_looked

    def pick(self) -> bool:
        target = self.target
        can_pick = target is not None and ActionKind.PICK in target.rates
        return can_pick and self.actions.pick(cast(int, self.index))

    def clear(self) -> bool:
        target = self.target
        can_clear = target is not None and ActionKind.CLEAR in target.rates
        return can_clear and self.actions.clear(cast(int, self.index))

    def give_up(self) -> bool:
        if self.target is not None:
            self.actions.give_up(self.target.index)
        return True

    def leaves(self) -> Mapping[str, Callable[..., bool]]:
        """Functions of all conditions and actions, by name of the node type."""
        return {
            "has_time_to_plan": lambda: self.actions.has_time_to_plan,
            "is_action": self.is_action,
            "has_no_plan": self.has_no_plan,
            "attempts_below": self.attempts_below,
            "choose_action": self.choose_action,
            "choose_target": self.choose_target,
            "look": self.look,
            "pick": self.pick,
            "clear": self.clear,
            "give_up": self.give_up,
        }
