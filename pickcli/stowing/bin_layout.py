"""Layout of the items of one bin, before physics lets them come to rest.

People who stock a pod lay things side by side so that all can be seen, stack only what is left over, and put
right what turned out badly.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.item import Item
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.stowing.packing_search import fill

N_LAYOUTS = 3  # of the best packings; the search copies the best, so they may be the same


@dataclass(frozen=True)
class ItemInstance:
    """One instance to be placed.

    Attributes:
        id: Unique in the scene.
        item: What it is.
    """

    id: str
    item: Item


def lay_out(
    scene: Scene,
    bin_name: str,
    contents: Sequence[ItemInstance],
    seed: int,
    may_raise: bool = False,
    tell: Callable[[], None] = lambda: None,
) -> list[tuple[PlacedItem, ...]]:
    """Layouts of the contents of a bin, a little above where they will lie.

    Args:
        scene: The scene that the bin is in.
        bin_name: Name of the bin.
        contents: What is to be placed.
        seed: Seed of all random choices.
        may_raise: Whether things may stand higher than the mouth, brought in lying and raised inside.
        tell: Called before every step of the search.

    Returns:
        Layouts, the best first; none if the contents found no room.
    """
    cell_bin = scene.cell.places[bin_name]
    items = [entry.item for entry in contents]
    packings = fill(cell_bin, items, np.random.default_rng(seed), may_raise, tell)
    T_world_bin = scene.T_world_place(cell_bin)
    full = np.flatnonzero(packings.is_full())
    best = full[np.argsort(packings.cost[full], kind="stable")][:N_LAYOUTS]
    poses = [packings.poses(k) for k in best.tolist()]
    return [
        tuple(
            PlacedItem(entry.id, entry.item, bin_name, T_world_bin @ T_bin_item)
            for entry, T_bin_item in zip(contents, T_bin_items, strict=True)
        )
        for n, T_bin_items in enumerate(poses)
        # Physics says the same of the same layout.
        if not any(np.array_equal(T_bin_items, earlier) for earlier in poses[:n])
    ]
