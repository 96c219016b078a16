"""Layouts of the items of one bin, before they come to rest in physics.

Modelled on people who stock a pod: items side by side and visible, stacked only if necessary, and rearranged
if the result is bad.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.item import Item
from pickcli.random_scenes.bin_packings import NONE_LEANS
from pickcli.random_scenes.leaning_placements import LeanKind
from pickcli.random_scenes.packing_search import fill
from pickcli.scene.scene import PlacedItem, Scene

N_LAYOUTS = 3  # number of best packings; duplicates are removed, as the search copies the best


@dataclass(frozen=True)
class ItemInstance:
    """One item instance to be placed.

    Attributes:
        id: Unique in the scene.
        item: The product.
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
    leaning: Mapping[int, Sequence[LeanKind]] = NONE_LEANS,
) -> list[tuple[PlacedItem, ...]]:
    """Compute layouts of a bin's contents, slightly above their resting poses.

    Args:
        scene: The scene that the bin is in.
        bin_name: Name of the bin.
        contents: Items to be placed.
        seed: Seed of all random choices.
        may_raise: Whether items may be higher than the mouth, inserted lying and tilted up inside.
        tell: Called before every step of the search.
        leaning: Indices of the items that are to lean, each with how it may.

    Returns:
        Layouts, the best first; empty if the contents do not fit.
    """
    cell_bin = scene.cell.places[bin_name]
    items = [entry.item for entry in contents]
    packings = fill(cell_bin, items, np.random.default_rng(seed), may_raise, tell, leaning)
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
        # Physics gives the same result for equal layouts.
        if not any(np.array_equal(T_bin_items, earlier) for earlier in poses[:n])
    ]
