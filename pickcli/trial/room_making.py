"""Moves an item of a bin elsewhere if that is all that keeps an item of the tote from being stowed there.

Much that can be taken out of the tote finds no free place on any floor, and what it covers in the heap stays
with it. The rules of 2016 state no penalty for items moved between bins if the output file lists them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from pickcli.cell.tool import Tool
from pickcli.errors import NoPlanError
from pickcli.grasping.method_choice import may_hold
from pickcli.motion.plan import Grasp
from pickcli.scene.scene import TOTE, PlacedItem, Scene
from pickcli.trial.attempt_runner import AttemptRunner
from pickcli.trial.item_moves import ItemMoves
from pickcli.trial.trial_result import Attempt

MOST_TRIED = 6  # items in bins


class RoomMaking:
    """Makes room in bins, and remembers for which items that was not possible.

    Args:
        runner: Runner for planning calls, charged to its clock.
        moves: Moves the items of bins.
        tools: Tools of all arms.
    """

    def __init__(self, runner: AttemptRunner, moves: ItemMoves, tools: Sequence[Tool]) -> None:
        self._runner, self._moves, self._tools = runner, moves, tools
        # By id of an item of the tote, contents of the bins in which no room could be made for it.
        self._in_vain: dict[str, frozenset[tuple[str, str]]] = {}

    def make_room(
        self, attempt: Attempt, scene: Scene, bins: Sequence[str], exclude: Sequence[Grasp]
    ) -> Attempt | None:
        """Move an item of a bin into another bin, so that an item of the tote can take its place.

        Args:
            attempt: The attempt at the item of the tote, which can leave it.
            scene: The perceived scene.
            bins: Bins into which it may be stowed, the best first.
            exclude: Grasps of the item that failed before.

        Returns:
            The attempt at the item of the bin with its outcome; None if nothing helps, or did not in bins
            with the same contents.
        """
        in_bins = frozenset((p.id, p.location) for p in scene.items if p.location != TOTE)
        if self._in_vain.get(attempt.item) == in_bins:
            return None
        self._runner.say(attempt, "looking for room in a bin")
        wanted = self._runner.ranked(attempt, scene)
        for inside in items_in_the_place_of(self._runner, wanted, scene, bins, self._tools, exclude):
            now = self._runner.clock.now
            aside = replace(attempt, item=inside.id, t_start=now, out_of=inside.location, is_aside=True)
            moved = self._moves.move_into_another_bin(aside, scene)
            if moved is not None:
                return moved
        self._in_vain[attempt.item] = in_bins
        return None


def items_in_the_place_of(
    runner: AttemptRunner,
    attempt: Attempt,
    scene: Scene,
    bins: Sequence[str],
    tools: Sequence[Tool],
    exclude: Sequence[Grasp] = (),
) -> Iterator[PlacedItem]:
    """Find items of bins without which there would be a plan for a stow.

    Of the emptiest bins first, in a bin the smallest item first; MOST_TRIED at most are tried.

    Args:
        runner: Runner for planning calls, charged to its clock.
        attempt: The attempt at the stow, with the arms ranked for it.
        scene: The perceived scene.
        bins: Bins into which the item may be stowed, the best first.
        tools: Tools of all arms.
        exclude: Grasps of the item that failed before.

    Yields:
        Items that a tool may hold.
    """
    held = [p for name in bins for p in scene.in_location(name) if may_hold(tools, p.item)]
    n_items = {name: len(scene.in_location(name)) for name in bins}
    held.sort(key=lambda p: (n_items[p.location], bins.index(p.location), p.item.shape.volume, p.id))
    for placed in held[:MOST_TRIED]:
        if not runner.has_time_to_plan:
            return
        try:
            runner.plan(scene.without(placed.id), replace(attempt, into=placed.location), exclude)
        except NoPlanError:
            continue
        yield placed
