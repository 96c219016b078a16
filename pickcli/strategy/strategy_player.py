"""Plays a strategy: ticks its tree, by py_trees, and records every tick of a condition or an action.

Actions are carried out within their tick and never return "running". A tree with a failed ``retry`` returns
"running"; the next tick continues there, as control nodes remember the child at which they were.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, cast

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Selector, Sequence
from py_trees.decorators import Decorator, FailureIsSuccess, Inverter, Retry

from pickcli.strategy.node_types import ActionKind
from pickcli.strategy.strategy_tree import Strategy, StrategyNode
from pickcli.strategy.target_choice import best_action, first_target
from pickcli.strategy.trial_actions import OpenTarget, TrialActions

SAME_TIME = 1e-6  # s
MAX_IDLE_TICKS = 100  # ticks of the tree in which it does nothing but look, after which it ends


@dataclass(frozen=True)
class Tick:
    """One tick of a condition or an action.

    Attributes:
        t: Time on the trial's clock when it began, s.
        node: The node, with its arguments.
        target: The chosen target at its end, also if the action closed it; "" if none is chosen.
        is_success: Whether it succeeded.
    """

    t: float
    node: str
    target: str
    is_success: bool


class StrategyPlayer:
    """Ticks a strategy in a trial.

    Args:
        strategy: The strategy.
        actions: The trial.

    Attributes:
        ticks: All ticks of conditions and actions so far.
        stuck: Why the strategy was ended before its tree failed; "" if it was not.
    """

    def __init__(self, strategy: Strategy, actions: TrialActions) -> None:
        self.ticks: list[Tick] = []
        self.stuck = ""
        self._actions = actions
        self._choice = _Choice(actions)
        self._tree = _built(strategy.root, self._choice, self.ticks)
        self._n_idle = 0

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
        self._tree.tick_once()
        if self._tree.status is Status.FAILURE:
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


class _Leaf(Behaviour):
    """A condition or an action."""

    def __init__(self, node: StrategyNode, choice: _Choice, ticks: list[Tick]) -> None:
        super().__init__(str(node))
        self._function, self._arguments = choice.leaves()[node.name], node.arguments
        self._choice, self._ticks = choice, ticks

    def update(self) -> Status:
        """Carry it out, and record it."""
        t, index, before = self._choice.actions.now, self._choice.index, self._choice.target
        is_success = bool(self._function(**self._arguments))
        target = self._choice.target or (before if self._choice.index == index else None)
        self._ticks.append(Tick(t, self.name, "" if target is None else str(target), is_success))
        return Status.SUCCESS if is_success else Status.FAILURE


class _Deadline(Decorator):
    """Fails without ticking its child if less time than ``seconds_left`` is left on the trial's clock."""

    def __init__(self, name: str, child: Behaviour, actions: TrialActions, seconds_left: float) -> None:
        super().__init__(name=name, child=child)
        self._actions, self._seconds_left = actions, seconds_left

    def tick(self) -> Any:
        """Tick the child if there is time."""
        if self._actions.time_left < self._seconds_left:
            self.stop(Status.FAILURE)
            yield self
        else:
            yield from super().tick()

    def update(self) -> Status:
        """Return the status of the child."""
        return self.decorated.status


def _built(node: StrategyNode, choice: _Choice, ticks: list[Tick]) -> Behaviour:
    """Build the behaviour of a node with everything below it."""
    children = [_built(child, choice, ticks) for child in node.children]
    name = str(node)
    match node.name:
        case "sequence":
            return Sequence(name, memory=True, children=children)
        case "fallback":
            return Selector(name, memory=True, children=children)
        case "retry":
            return Retry(name, children[0], cast(int, node.arguments["attempts"]))
        case "invert":
            return Inverter(name, children[0])
        case "force_success":
            return FailureIsSuccess(name, children[0])
        case "deadline":
            return _Deadline(name, children[0], choice.actions, cast(float, node.arguments["seconds_left"]))
    return _Leaf(node, choice, ticks)
