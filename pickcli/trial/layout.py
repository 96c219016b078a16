"""Where the items of one bin go, before physics lets them come to rest.

Whoever stocks a pod lays things side by side so that all can be seen, stacks only what is left over, and puts
right what turned out badly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.scene import PlacedItem, Scene
from pickcli.trial.packing import fill

N_LAYOUTS = 3  # at most: the best fillings, often variants of each other


@dataclass(frozen=True)
class Contents:
    """One instance to be placed."""

    id: str
    item: Item


def lay_out(
    scene: Scene, bin_name: str, contents: Sequence[Contents], seed: int, may_raise: bool = False
) -> list[tuple[PlacedItem, ...]]:
    """The contents of a bin a little above where they will lie, best first; nothing if they found no room.

    may_raise: whether things may stand higher than the mouth, brought in lying and raised inside
    """
    cell_bin = scene.cell.pod.bins[bin_name]
    items = [entry.item for entry in contents]
    fillings = fill(cell_bin, items, np.random.default_rng(seed), may_raise)
    T_world_bin = scene.T_world_pod @ cell_bin.T_pod_bin
    full = np.flatnonzero(fillings.is_full())
    best = full[np.argsort(fillings.cost[full], kind="stable")][:N_LAYOUTS]
    return [
        tuple(
            PlacedItem(entry.id, entry.item, bin_name, T_world_bin @ T_bin_item)
            for entry, T_bin_item in zip(contents, fillings.poses(k), strict=True)
        )
        for k in best.tolist()
    ]
