"""Search for blocking items, one after the other, until a target can be picked, and for their destinations.

Delft moved an item that hid a target into the emptiest bin after two failed attempts (their task planner).
Here `planning.blockers` finds which items matter. Items that fit in no other bin go into the tote: the
published penalties of 2016 include none for an item there that was not ordered, provided that the output file
lists it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from functools import cached_property

from pickcli.cell.tool import Tool
from pickcli.errors import NoPlanError
from pickcli.grasping.method_choice import may_hold
from pickcli.motion.plan import Grasp
from pickcli.planning.blockers import blocking_items, worth_moving
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.trial.attempt_runner import AttemptRunner
from pickcli.trial.order import Target
from pickcli.trial.trial_result import Attempt

MOST_DESTINATIONS = 4  # number of bins tried as destinations of a blocking item


class Clearing:
    """Blocking items of one target in one scene, the most blamed first.

    Attributes:
        is_reachable: Whether a plan for the target was found in the unchanged scene, so nothing need be
            moved.

    Args:
        runner: Runner for planning calls, charged to its clock.
        wanted: The attempt at the target, with the arms ranked for it.
        scene: The perceived scene.
        tools: Tools of all arms.
        exclude: Grasps of the target that failed before.
    """

    def __init__(
        self,
        runner: AttemptRunner,
        wanted: Attempt,
        scene: Scene,
        tools: Sequence[Tool],
        exclude: Sequence[Grasp],
    ) -> None:
        self._runner, self._wanted, self._scene = runner, wanted, scene
        self._tools, self._exclude = tools, exclude
        self._queue: list[str] = []
        self._returned: set[str] = set()
        self.is_reachable = False

    def blame(self, is_hopeful: bool, blamed: Sequence[str] | None) -> None:
        """Find the items that block the target.

        Args:
            is_hopeful: Whether blamed items count even if moving them is not known to be enough.
            blamed: Items blamed by a failed plan in this scene, if there is one.
        """
        self._queue += blocking_items(self._what_if, self._scene, self._target, is_hopeful, blamed)

    def next_item(self) -> str | None:
        """Return the next blocking item that a tool may hold; each is returned once.

        Returns:
            Its id; None if there is none left.
        """
        left = (name for name in self._promising() if name not in self._returned)
        name = next((name for name in left if may_hold(self._tools, self._scene.find(name).item)), None)
        self._returned |= set() if name is None else {name}
        return name

    def also(self, names: Sequence[str]) -> None:
        """Add items of the target's place, such as items on top of one that could not be moved.

        Args:
            names: Ids; items in other places are ignored.
        """
        here = {p.id for p in self._scene.in_location(self._target.location)} - {self._target.id}
        self._queue += [name for name in names if name in here]

    @cached_property
    def _target(self) -> PlacedItem:
        return self._scene.find(self._wanted.item)

    @cached_property
    def _others(self) -> tuple[str, ...]:
        """The other items of the place; costs a planning call, so used only if no blamed item is movable."""
        return worth_moving(self._what_if, self._scene, self._target, self._tools)

    def _promising(self) -> Iterator[str]:
        yield from self._queue
        yield from self._others

    def _what_if(self, without: Scene) -> None:
        """Plan the pick in another scene. Raises NoPlanError if there is no plan, or no time to plan."""
        if not self._runner.has_time_to_plan:
            raise NoPlanError("a pick without what is in its way", [])
        self._runner.plan(without, self._wanted, self._exclude)
        self.is_reachable = self.is_reachable or without is self._scene


def destinations(
    scene: Scene, bin_name: str, still_open: Sequence[Target], left: Collection[str] = ()
) -> Iterator[str]:
    """Choose other bins as destinations of a blocking item.

    Args:
        scene: The perceived scene.
        bin_name: The bin from which the item is removed.
        still_open: Targets still to be picked.
        left: Places to which it is not to return.

    Yields:
        Names of bins, at most MOST_DESTINATIONS: the emptiest first, bins with open targets last.
    """
    waiting = {target.bin for target in still_open}
    others = [name for name in scene.cell.pod.bins if name != bin_name and name not in left]
    others.sort(key=lambda name: (name in waiting, len(scene.in_location(name)), name))
    yield from others[:MOST_DESTINATIONS]
