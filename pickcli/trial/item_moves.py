"""Moves one item in a trial: to its destination, aside, or over onto another side."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

from pickcli.motion.plan import GraspKind
from pickcli.scene.scene import TOTE, Scene
from pickcli.trial.aside_memory import AsideMemory
from pickcli.trial.attempt_execution import carry_out
from pickcli.trial.attempt_memory import AttemptMemory
from pickcli.trial.attempt_runner import AttemptRunner
from pickcli.trial.clearing import destinations
from pickcli.trial.order import ANY_BIN, Order, Target
from pickcli.trial.trial_result import Attempt, Outcome

NO_TIME_TO_PLAN = "no time is left to plan it"

Exchange: TypeAlias = Callable[[Attempt], Attempt | None]


def nothing_better(planned: Attempt) -> Attempt | None:
    """Let a planned attempt be carried out.

    Args:
        planned: The attempt.
    """


class ItemMoves:
    """Moves of single items, each planned without the grasps that failed before.

    Args:
        order: The order of the trial.
        runner: Plans and executes.
        memory: What failed before; not changed.
        asides: What was moved aside before; not changed.
        bins: Of a stow, by item name the bins to try, in this order.
    """

    def __init__(
        self,
        order: Order,
        runner: AttemptRunner,
        memory: AttemptMemory,
        asides: AsideMemory,
        bins: Mapping[str, Sequence[str]],
    ) -> None:
        self._order, self._runner, self._bins = order, runner, bins
        self._memory, self._asides = memory, asides

    def move(self, attempt: Attempt, scene: Scene, instead: Exchange = nothing_better) -> Attempt:
        """Play an attempt to its end.

        Args:
            attempt: The item, its place and destination; ANY_BIN for the first of its bins that has room.
            scene: The perceived scene.
            instead: Asked once there is a plan for an attempt at another item that was made instead.

        Returns:
            The attempt with its outcome, or the one made instead.
        """
        if attempt.into == ANY_BIN:
            return self._stowed(attempt, scene, instead)
        planned = self._planned(attempt, scene)
        return planned if planned.plan is None else instead(planned) or carry_out(self._runner, planned)

    def move_aside(self, attempt: Attempt, scene: Scene, still_open: Sequence[Target]) -> Attempt:
        """Try to move an item into another bin, or into the tote if none has room.

        An item that cannot be brought into the tote cannot leave its bin, so no other bin is tried. Items to
        be stowed are moved within the tote only, as stowing them has been tried separately.

        Args:
            attempt: The item and its place.
            scene: The perceived scene.
            still_open: Targets still to be picked.

        Returns:
            The attempt with its outcome.
        """
        attempt = replace(attempt, t_start=self._runner.clock.now)
        out = self._planned(replace(attempt, into=TOTE), scene)
        if out.plan is None:
            return out
        moved = None if attempt.out_of == TOTE else self.move_into_another_bin(attempt, scene, still_open)
        return moved or carry_out(self._runner, out)

    def move_into_another_bin(
        self, attempt: Attempt, scene: Scene, still_open: Sequence[Target] = ()
    ) -> Attempt | None:
        """Try to move an item into another bin, none that it was moved out of for a target that is open.

        Args:
            attempt: The item and its place.
            scene: The perceived scene.
            still_open: Targets still to be picked.

        Returns:
            The attempt with its outcome; None if no plan leads there.
        """
        for into in destinations(scene, attempt.out_of, still_open, self._asides.left(attempt.item)):
            if not self._runner.has_time_to_plan:
                break
            moved = self.move(replace(attempt, into=into), scene)
            if moved.plan is not None:
                return moved
        return None

    def topple(self, attempt: Attempt, scene: Scene) -> Attempt:
        """Push an item over onto another side.

        Args:
            attempt: The item and its place.
            scene: The perceived scene.

        Returns:
            The attempt with its outcome.
        """
        self._runner.say(attempt, "planning to topple it")
        planned = self._runner.toppling(attempt, scene)
        return planned if planned.plan is None else carry_out(self._runner, planned)

    def _stowed(self, attempt: Attempt, scene: Scene, instead: Exchange) -> Attempt:
        """Try to bring an item into the first of its bins that has room, unless it cannot leave its place."""
        if not self._runner.has_time_to_plan:
            return replace(attempt, outcome=Outcome.NO_TIME, reason=NO_TIME_TO_PLAN)
        first: Attempt | None = None
        for name in self._bins[attempt.target.item]:
            if not self._runner.has_time_to_plan:
                break
            tried = self.move(replace(attempt, into=name), scene, instead)
            if tried.item != attempt.item:
                return tried
            if tried.execution is not None or tried.outcome is Outcome.NO_TIME:
                is_there = self._order.is_met(attempt.target, tried.seen_in)
                return replace(tried, outcome=Outcome.DELIVERED) if is_there else tried
            first = first or tried
            if not tried.has_way_out:
                break
        return first or replace(attempt, outcome=Outcome.NO_PLAN, reason="no bin is large enough for it")

    def _planned(self, attempt: Attempt, scene: Scene) -> Attempt:
        """Plan with a kind of grasp that has not failed, else with another grasp of a kind that has."""
        if not self._runner.has_time_to_plan:
            return replace(attempt, outcome=Outcome.NO_TIME, reason=NO_TIME_TO_PLAN)
        self._runner.say(attempt, "planning")
        in_vain = self._memory.failed_grasps(attempt.item)
        kinds = tuple(dict.fromkeys(GraspKind(grasp.kind, grasp.face) for grasp in in_vain))
        if kinds:
            found = self._runner.planned(attempt, scene, (*in_vain, *kinds))
            if found.plan is not None or not self._runner.has_time_to_plan:
                return found
            attempt = replace(attempt, rejected=found.rejected)
            in_vain = (*in_vain, *(plan.grasp for plan in found.rejected if plan.grasp is not None))
        return self._runner.planned(attempt, scene, in_vain)
