"""From an order to a scene: every item with its real size, at rest in its bin.

Bins are filled one by one, each from a seed of its own (scene seed, bin, attempt), so that a bin looks the
same whatever the others hold. Targets of the order are not treated differently from the rest.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.model import Cell
from pickcli.cell.scene import PlacedItem, PoseNoise, Scene
from pickcli.errors import InputError, Reason
from pickcli.simulation.settle import settle
from pickcli.trial.noise import derived_seed
from pickcli.trial.packing import BinMap
from pickcli.trial.stances import stances

N_ATTEMPTS = 120  # layouts tried per bin, tidier and tidier
THIN = 0.022  # m

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class Contents:
    """One instance to be placed."""

    id: str
    item: Item


def make_scene(
    bin_contents: Mapping[str, Sequence[str]],
    cell: Cell,
    seed: int,
    year: int = 2016,
    on_progress: Progress | None = None,
) -> Scene:
    """Place all bin items of an order in their bins, at rest and without overlap.

    bin_contents: item names by bin
    year: which figures an item of two years has
    on_progress: called with (bins done, bins in all, name of the bin)
    Raises InputError naming the bin whose items do not fit, and why; UnknownNameError.
    """
    empty = Scene(cell, cell.T_world_pod, (), PoseNoise(), seed)
    ids: dict[str, int] = {}
    items: list[PlacedItem] = []
    for done, (bin_name, names) in enumerate(sorted(bin_contents.items())):
        if on_progress is not None:
            on_progress(done, len(bin_contents), bin_name)
        contents = [Contents(_instance_id(name, ids), cell.item(name, year)) for name in names]
        items.extend(fill_bin(empty, bin_name, contents, seed))
    return Scene(cell, cell.T_world_pod, tuple(items), PoseNoise(), seed)


def fill_bin(scene: Scene, bin_name: str, contents: Sequence[Contents], seed: int) -> tuple[PlacedItem, ...]:
    """The contents of one bin at rest. Raises InputError when no attempt succeeds."""
    reasons: list[Reason] = []
    for attempt in range(N_ATTEMPTS if contents else 0):
        rng = np.random.default_rng(derived_seed("layout", seed, bin_name, attempt))
        order = sorted(contents, key=ORDERS[attempt % len(ORDERS)], reverse=True)
        layout = _lay_out(scene, bin_name, order, rng, tidiness=attempt / (N_ATTEMPTS - 1))
        outcome = layout if isinstance(layout, Reason) else settle(scene, layout)
        if not isinstance(outcome, Reason):
            return outcome
        reasons.append(outcome)
    if not contents:
        return ()
    raise InputError(
        f"{bin_name}: its {len(contents)} items do not fit at rest in {N_ATTEMPTS} attempts "
        f"(last: {reasons[-1]}); take another seed or put fewer items into this bin"
    )


def _lay_out(
    scene: Scene, bin_name: str, contents: Sequence[Contents], rng: np.random.Generator, tidiness: float
) -> tuple[PlacedItem, ...] | Reason:
    """Poses a little above where the items will lie, in the order given."""
    cell_bin = scene.cell.pod.bins[bin_name]
    bin_map = BinMap(cell_bin)
    T_world_bin = scene.T_world_pod @ cell_bin.T_pod_bin
    placed = []
    for entry in contents:
        spot = bin_map.find(entry.item, rng, tidiness)
        if spot is None:
            return Reason("no room", bin_name, entry.id)
        bin_map.occupy(spot)
        placed.append(PlacedItem(entry.id, entry.item, bin_name, T_world_bin @ spot.T_bin_item))
    return tuple(placed)


def _base(entry: Contents) -> tuple[float, str]:
    """By the area covered when lying flat; the id breaks ties."""
    width, depth = stances(entry.item.shape)[0][0].footprint
    return width * depth, entry.id


def _level_first(entry: Contents) -> tuple[bool, float, str]:
    """Level ones before round ones, on which nothing lies; a bin so filled holds most."""
    return stances(entry.item.shape)[0][0].is_level, *_base(entry)


def _thin_first(entry: Contents) -> tuple[bool, float, str]:
    """Envelopes and books under everything else."""
    return stances(entry.item.shape)[0][0].height < THIN, *_base(entry)


ORDERS = (_level_first, _base, _thin_first)  # in which a bin is filled, by turns


def _instance_id(name: str, seen: dict[str, int]) -> str:
    """``name`` for the first copy in the scene, ``name#2`` for the second."""
    seen[name] = seen.get(name, 0) + 1
    return name if seen[name] == 1 else f"{name}#{seen[name]}"
