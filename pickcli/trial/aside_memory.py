"""Remembers what was moved aside for which target, so that no such move is undone or repeated for nothing."""

from __future__ import annotations

from collections import defaultdict

from pickcli.scene.scene import Scene
from pickcli.trial.target_list import TargetList
from pickcli.trial.trial_result import Attempt, Outcome


class AsideMemory:
    """Moves of items aside.

    Args:
        targets: The targets of the trial; what was moved for one matters while that one is open.
    """

    def __init__(self, targets: TargetList) -> None:
        self._targets = targets
        self._left: dict[str, list[tuple[str, int]]] = defaultdict(list)  # by item, places and target indices
        self._within: dict[
            str, frozenset[str]
        ] = {}  # by item moved within its place, all that was there then

    def note(self, index: int, attempt: Attempt, scene: Scene) -> None:
        """Remember an attempt if it moved an item aside.

        Args:
            index: Index of the target that it was made for.
            attempt: The attempt.
            scene: The scene as perceived after it.
        """
        if attempt.outcome is not Outcome.MOVED or attempt.topples:
            return
        if attempt.into == attempt.out_of:
            self._within[attempt.item] = _contents(scene, attempt.into)
        else:
            self._left[attempt.item].append((attempt.out_of, index))

    def left(self, item: str) -> frozenset[str]:
        """Return the places to which an item is not to return.

        Args:
            item: Its id.

        Returns:
            Places that it was moved out of for targets that are still open.
        """
        return frozenset(place for place, index in self._left.get(item, ()) if index in self._targets.open)

    def would_repeat(self, item: str, place: str, scene: Scene) -> bool:
        """Whether an item was moved within its place before, and the same items are still there.

        Args:
            item: Its id.
            place: Its place.
            scene: The perceived scene.

        Returns:
            True if moving it there again would only shuffle what is there.
        """
        return self._within.get(item) == _contents(scene, place)


def _contents(scene: Scene, place: str) -> frozenset[str]:
    return frozenset(placed.id for placed in scene.in_location(place))
