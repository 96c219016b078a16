"""Ticks a behaviour tree, by py_trees, and records every tick of a condition or an action.

Actions are carried out within their tick and never return "running". A tree with a failed ``retry`` returns
"running"; the next tick continues there, as control nodes remember the child at which they were.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol, cast

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Selector, Sequence
from py_trees.decorators import Decorator, FailureIsSuccess, Inverter, Retry

from pickcli.strategy.strategy_tree import Argument, StrategyNode


class Leaves(Protocol):
    """What carries out the conditions and actions of a tree."""

    @property
    def now(self) -> float:
        """Time on the trial's clock, s."""

    @property
    def time_left(self) -> float:
        """Time until the end of the trial, s."""

    def run(self, name: str, arguments: Mapping[str, Argument]) -> tuple[bool, str]:
        """Carry out a condition or an action.

        Args:
            name: Name of the node's type.
            arguments: Values of its parameters, by name.

        Returns:
            Whether it succeeded, and the target that it was for, "" for none.
        """


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


class TreePlayer:
    """Ticks a tree.

    Args:
        root: The root of the tree.
        leaves: What carries out its conditions and actions.

    Attributes:
        ticks: All ticks of conditions and actions so far.
    """

    def __init__(self, root: StrategyNode, leaves: Leaves) -> None:
        self.ticks: list[Tick] = []
        self._tree = _built(root, leaves, self.ticks)

    def tick(self) -> bool | None:
        """Tick the tree once.

        Returns:
            Whether it succeeded or failed; None if it goes on in the next tick.
        """
        self._tree.tick_once()
        if self._tree.status is Status.RUNNING:
            return None
        return bool(self._tree.status is Status.SUCCESS)


class _Leaf(Behaviour):
    """A condition or an action."""

    def __init__(self, node: StrategyNode, leaves: Leaves, ticks: list[Tick]) -> None:
        super().__init__(str(node))
        self._node, self._leaves, self._ticks = node, leaves, ticks

    def update(self) -> Status:
        """Carry it out, and record it."""
        t = self._leaves.now
        is_success, target = self._leaves.run(self._node.name, self._node.arguments)
        self._ticks.append(Tick(t, self.name, target, is_success))
        return Status.SUCCESS if is_success else Status.FAILURE


class _Deadline(Decorator):
    """Fails without ticking its child if less time than ``seconds_left`` is left on the trial's clock."""

    def __init__(self, name: str, child: Behaviour, leaves: Leaves, seconds_left: float) -> None:
        super().__init__(name=name, child=child)
        self._leaves, self._seconds_left = leaves, seconds_left

    def tick(self) -> Any:
        """Tick the child if there is time."""
        if self._leaves.time_left < self._seconds_left:
            self.stop(Status.FAILURE)
            yield self
        else:
            yield from super().tick()

    def update(self) -> Status:
        """Return the status of the child."""
        return self.decorated.status


def _built(node: StrategyNode, leaves: Leaves, ticks: list[Tick]) -> Behaviour:
    """Build the behaviour of a node with everything below it."""
    children = [_built(child, leaves, ticks) for child in node.children]
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
            return _Deadline(name, children[0], leaves, cast(float, node.arguments["seconds_left"]))
    return _Leaf(node, leaves, ticks)
