"""Remembers what failed in a trial, so that nothing is asked for twice in the same situation."""

from __future__ import annotations

from pickcli.motion.plan import Grasp
from pickcli.scene.scene import Scene
from pickcli.simulation.protective_stop import StopCause
from pickcli.trial.trial_result import Attempt, Outcome

_MISSEEN = (StopCause.EARLY_CONTACT, StopCause.WRONG_WEIGHT)


class AttemptMemory:
    """Failed grasps, refused targets and items that cannot leave their place."""

    def __init__(self) -> None:
        self._grasps: dict[str, tuple[Grasp, ...]] = {}  # that failed, by item id
        self._refused: dict[int, tuple[Scene, Attempt]] = {}  # last attempt without a plan, by target index
        self._stuck: tuple[Scene | None, dict[str, Attempt]] = (None, {})  # in a scene as perceived once

    def note(self, attempt: Attempt, scene: Scene) -> None:
        """Learn from an attempt, of any kind.

        Args:
            attempt: The attempt.
            scene: The scene as last perceived.
        """
        if attempt.plan is None:
            is_stuck = attempt.is_aside or not attempt.has_way_out
            if is_stuck and not attempt.topples and attempt.outcome in (Outcome.NO_PLAN, Outcome.REJECTED):
                self._stuck_in(scene)[attempt.item] = attempt
            return
        # An early contact shows a wrong pose of the item, a wrong weight another item, not a bad grasp.
        is_misseen = attempt.execution is not None and attempt.execution.stop_cause in _MISSEEN
        is_there = attempt.outcome.is_delivered or attempt.outcome is Outcome.MOVED
        if attempt.plan.grasp is not None and not is_there and not is_misseen:
            self._grasps[attempt.item] = (*self.failed_grasps(attempt.item), attempt.plan.grasp)

    def failed_grasps(self, item: str) -> tuple[Grasp, ...]:
        """Return the grasps of an item that failed.

        Args:
            item: Its id.

        Returns:
            The grasps, in order of time.
        """
        return self._grasps.get(item, ())

    def refuse(self, index: int, attempt: Attempt, scene: Scene) -> None:
        """Remember that there was no plan for a target.

        Args:
            index: Index of the target.
            attempt: The attempt without a plan.
            scene: The perceived scene.
        """
        self._refused[index] = (scene, attempt)

    def blamed(self, index: int, item: str, scene: Scene) -> tuple[str, ...] | None:
        """Return the items that the last attempt at a target blamed, if it was made in a scene.

        Args:
            index: Index of the target.
            item: Id of the item that the target is to be fulfilled by.
            scene: The scene.

        Returns:
            Ids; None if there was no such attempt in that scene as perceived once.
        """
        seen, attempt = self._refused.get(index, (None, None))
        return attempt.in_the_way if attempt is not None and seen is scene and attempt.item == item else None

    def may_help(self, attempt: Attempt, index: int) -> bool:
        """Whether an attempt moved what a failed plan for a target blamed, or there was none.

        Args:
            attempt: The attempt.
            index: Index of the target.

        Returns:
            True if it did.
        """
        if index not in self._refused or attempt.plan is None:
            return True
        _, refused = self._refused[index]
        pushed = {name for segment in attempt.plan.segments for name in segment.pushing}
        return bool({attempt.item, *pushed} & {refused.item, *refused.in_the_way})

    def stuck(self, item: str, scene: Scene) -> Attempt | None:
        """Return the failed attempt at an item that cannot leave its place in a scene.

        Args:
            item: Its id.
            scene: The scene.

        Returns:
            The attempt; None if there was none in that scene as perceived once.
        """
        return self._stuck_in(scene).get(item)

    def _stuck_in(self, scene: Scene) -> dict[str, Attempt]:
        if self._stuck[0] is not scene:
            self._stuck = (scene, {})
        return self._stuck[1]
