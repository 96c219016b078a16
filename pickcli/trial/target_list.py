"""The targets of a trial: which are open, and which of the perceived items could fulfil them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping

from pickcli.planning.blockers import from_the_mouth
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.strategy.trial_actions import OpenTarget
from pickcli.trial.action_values import AttemptOutcomes, TargetState, open_targets
from pickcli.trial.order import Order, may_move_others
from pickcli.trial.trial_result import Attempt


class TargetList:
    """The targets of a trial.

    Args:
        order: The order.
        states: One state per line of the order, as at the start.
        homes: By item id, the place that it is in at the start.

    Attributes:
        states: The states as at the start, in the order of the lines.
        open: By index, the present states of the targets for which something may still be tried.
    """

    def __init__(self, order: Order, states: tuple[TargetState, ...], homes: Mapping[str, str]) -> None:
        self.states = states
        self.open = {state.index: state for state in states}
        self._order = order
        self._homes = homes
        self._delivered: set[str] = set()
        self._outcomes = AttemptOutcomes()

    @property
    def n_done(self) -> int:
        """Number of targets that are closed."""
        return len(self.states) - len(self.open)

    def put(self, state: TargetState) -> TargetState:
        """Replace the state of a target, which is open from then on.

        Args:
            state: The new state.

        Returns:
            The new state.
        """
        self.open[state.index] = state
        return state

    def close(self, index: int) -> None:
        """Close a target.

        Args:
            index: Its index.
        """
        self.open.pop(index, None)

    def note(self, state: TargetState, attempt: Attempt) -> None:
        """Count the outcome of an executed attempt at a target.

        Args:
            state: The target.
            attempt: The attempt, with its plan.
        """
        assert attempt.plan is not None
        self._outcomes.note(state.target, attempt.outcome.is_delivered)
        self._delivered |= {attempt.item} if attempt.outcome.is_delivered else set()
        self.put(state.timed(attempt.plan.trajectory.duration))

    def valued(self, scene: Scene) -> tuple[OpenTarget, ...]:
        """List what is worth trying, with the value of each possible action.

        Args:
            scene: The scene as last perceived.

        Returns:
            The targets, in the order of their lines.
        """
        n_items = Counter(placed.location for placed in scene.items)
        return open_targets(self.open.values(), self._outcomes, may_move_others(self._order), n_items)

    def copies(self, scene: Scene, state: TargetState) -> tuple[PlacedItem, ...]:
        """Find the items that could fulfil a target, in any place except its destination.

        A copy counts for the place that it was in at the start, even after it has moved.

        Args:
            scene: The perceived scene.
            state: The target.

        Returns:
            The items.
        """
        return tuple(
            placed
            for placed in scene.items
            if placed.item.name == state.target.item
            and self._homes.get(placed.id) == state.target.bin
            and not self._order.is_met(state.target, placed.location)
            and placed.id not in self._delivered
        )

    def chosen_copy(self, scene: Scene, state: TargetState) -> PlacedItem | None:
        """Choose the copy of a target nearest to a mouth; on a retry the next one.

        Args:
            scene: The perceived scene.
            state: The target.

        Returns:
            The item; None if none is seen.
        """
        copies = from_the_mouth(scene, self.copies(scene, state))
        return copies[max(0, state.attempts - 1) % len(copies)] if copies else None

    def fulfilled_by(self, placed: PlacedItem, scene: Scene) -> tuple[TargetState, ...]:
        """Find the open targets that an item could fulfil.

        Args:
            placed: The item.
            scene: The perceived scene.

        Returns:
            Their states.
        """
        return tuple(state for state in self.open.values() if placed in self.copies(scene, state))

    def _locations(self, scene: Scene, state: TargetState) -> set[str]:
        return {placed.location for placed in self.copies(scene, state)} or {state.target.bin}

    def waiting_in(self, places: Collection[str], scene: Scene) -> tuple[TargetState, ...]:
        """Find the open targets of which a copy is in one of some places, or must be as none is perceived.

        Args:
            places: Names of the places.
            scene: The perceived scene.

        Returns:
            Their states.
        """
        return tuple(
            state
            for state in self.open.values()
            if any(name in places for name in self._locations(scene, state))
        )
