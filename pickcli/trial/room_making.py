"""Moves an item of a bin elsewhere if that is all that keeps an item of the tote from being stowed there.

Much that can be taken out of the tote finds no free place on any floor, and what it covers in the heap stays
with it; much else finds one only in bins that give few points, as the others are full. The rules of 2016
state no penalty for items moved between bins if the output file lists them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

from pickcli.cell.tool import Tool
from pickcli.errors import NoPlanError
from pickcli.grasping.method_choice import may_hold
from pickcli.motion.plan import Grasp
from pickcli.scene.scene import TOTE, PlacedItem, Scene
from pickcli.trial.attempt_runner import AttemptRunner
from pickcli.trial.item_moves import ItemMoves
from pickcli.trial.trial_result import Attempt

MOST_TRIED = 6  # items in bins, so that an item can be stowed at all
MOST_TRIED_FOR_POINTS = 12  # so that it gives more points


class RoomMaking:
    """Makes room in bins, and remembers for which items that was not possible.

    Args:
        runner: Runner for planning calls, charged to its clock.
        moves: Moves the items of bins.
        tools: Tools of all arms.
    """

    def __init__(self, runner: AttemptRunner, moves: ItemMoves, tools: Sequence[Tool]) -> None:
        self._runner, self._moves, self._tools = runner, moves, tools
        # By id of an item of the tote and the bins asked for, the contents of all bins when it was in vain.
        self._in_vain: dict[tuple[str, tuple[str, ...]], frozenset[tuple[str, str]]] = {}

    def make_room(
        self, attempt: Attempt, scene: Scene, bins: Sequence[str], exclude: Sequence[Grasp]
    ) -> Attempt | None:
        """Move an item of a bin into another bin, so that an item of the tote can take its place.

        The emptiest bins are tried first, in a bin the smallest item first.

        Args:
            attempt: The attempt at the item of the tote, which can leave it.
            scene: The perceived scene.
            bins: Bins into which it may be stowed, the best first.
            exclude: Grasps of the item that failed before.

        Returns:
            The attempt at the item of the bin with its outcome; None if nothing helps, or did not in bins
            with the same contents.
        """
        n_items = {name: len(scene.in_location(name)) for name in bins}
        emptiest = sorted(bins, key=lambda name: n_items[name])
        inside = (placed for name in emptiest for placed in _smallest_first(scene, name))
        return self._moved(attempt, scene, tuple(bins), [*inside], exclude, MOST_TRIED)

    def exchange(
        self,
        attempt: Attempt,
        scene: Scene,
        bins: Sequence[str],
        movable: Collection[str],
        exclude: Sequence[Grasp],
    ) -> Attempt | None:
        """Move an item of a bin that gives more points into another, for an item of the tote that has a plan.

        The bins are tried in their order, in a bin the smallest item first.

        Args:
            attempt: The attempt at the item of the tote.
            scene: The perceived scene.
            bins: Bins in which it gives more points, the best first.
            movable: Ids of items that give no points where they are.
            exclude: Grasps of the item that failed before.

        Returns:
            As for ``make_room``.
        """
        inside = (placed for name in bins for placed in _smallest_first(scene, name))
        worthless = [placed for placed in inside if placed.id in movable]
        return self._moved(attempt, scene, tuple(bins), worthless, exclude, MOST_TRIED_FOR_POINTS)

    def _moved(
        self,
        attempt: Attempt,
        scene: Scene,
        bins: tuple[str, ...],
        inside: Sequence[PlacedItem],
        exclude: Sequence[Grasp],
        most: int,
    ) -> Attempt | None:
        """Move the first of the items of bins in whose place there would be a plan; most: that are tried."""
        in_bins = frozenset((p.id, p.location) for p in scene.items if p.location != TOTE)
        if self._in_vain.get((attempt.item, bins)) == in_bins:
            return None
        self._runner.say(attempt, "looking for room in a bin")
        wanted = self._runner.ranked(attempt, scene)
        held = [placed for placed in inside if may_hold(self._tools, placed.item)]
        for placed in _in_the_place_of(self._runner, wanted, scene, held[:most], exclude):
            now = self._runner.clock.now
            aside = replace(attempt, item=placed.id, t_start=now, out_of=placed.location, is_aside=True)
            moved = self._moves.move_into_another_bin(aside, scene)
            if moved is not None:
                return moved
        self._in_vain[attempt.item, bins] = in_bins
        return None


def _smallest_first(scene: Scene, place: str) -> list[PlacedItem]:
    return sorted(scene.in_location(place), key=lambda placed: (placed.item.shape.volume, placed.id))


def _in_the_place_of(
    runner: AttemptRunner, stow: Attempt, scene: Scene, inside: Sequence[PlacedItem], exclude: Sequence[Grasp]
) -> Iterator[PlacedItem]:
    """Yield items of bins without which there would be a plan for a stow, in their order."""
    for placed in inside:
        if not runner.has_time_to_plan:
            return
        try:
            runner.plan(scene.without(placed.id), replace(stow, into=placed.location), exclude)
        except NoPlanError:
            continue
        yield placed
