"""Search for an item of a bin without which an item of the tote could be stowed there.

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
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.trial.attempt_runner import AttemptRunner
from pickcli.trial.trial_result import Attempt

MOST_TRIED = 6  # items in bins


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
