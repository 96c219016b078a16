"""Packing search: fills a bin with the large items first, then improves the order.

The search is bounded by counts, not by time. Packings start at random and are improved by moving one item at
a time, at first also with increasing cost; from time to time the worst are replaced by copies of the best.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.random_scenes.bin_packings import NONE_LEANS, BinPackings
from pickcli.random_scenes.leaning_placements import LeanKind

N_PACKINGS = 16
N_ROUNDS = 4  # largest number of attempts to insert all items
N_TRIES = 8  # moves for inserting an item
MOST_TRIES = 60  # moves for inserting an item that does not fit in any packing yet
VOLUME_SPREAD = 0.3  # standard deviation of the insertion order, in the logarithm of the volume
N_MOVES = 30  # largest number of moves per item after all are inserted
SELECTION = 25  # moves between selections
INITIAL_TOLERANCE = 3.0  # initial tolerance of increases in cost
STRICT_FROM = 2 / 3  # share of the moves after which the tolerance is 0
GOOD_COST = 0.3  # cost at which the search ends


def fill(
    cell_bin: Place,
    items: Sequence[Item],
    rng: np.random.Generator,
    may_raise: bool = False,
    tell: Callable[[], None] = lambda: None,
    leaning: Mapping[int, Sequence[LeanKind]] = NONE_LEANS,
) -> BinPackings:
    """Search packings of a bin.

    Args:
        cell_bin: The bin.
        items: Items to be packed.
        rng: Source of random numbers.
        may_raise: Whether items may be higher than the mouth, inserted lying and tilted up inside.
        tell: Called before every step of the search.
        leaning: Indices of the items that are to lean, each with how it may.

    Returns:
        Packings, unordered; some may lack items that did not fit.
    """
    empty = partial(BinPackings.empty, cell_bin, items, N_PACKINGS, may_raise, leaning)
    packings = _all_in(empty, rng, tell)
    n_moves = N_MOVES * len(items) if packings.is_full().any() else 0
    for k in range(n_moves):
        tell()
        packings.tidy_up()
        if packings.cost[packings.is_full()].min(initial=np.inf) <= GOOD_COST:
            break
        tolerance = INITIAL_TOLERANCE * max(0.0, 1.0 - k / (STRICT_FROM * n_moves))
        packings.move(int(rng.integers(len(items))), rng, tolerance)
        if k % SELECTION == SELECTION - 1:
            _select(packings)
    return packings


def _all_in(
    empty: Callable[[], BinPackings], rng: np.random.Generator, tell: Callable[[], None]
) -> BinPackings:
    """Restart from empty packings, up to ``N_ROUNDS`` times, until one contains all items."""
    for _ in range(N_ROUNDS):
        packings = empty()
        order = _large_first(packings, rng)
        for done, k in enumerate(order):
            _put_in(packings, k, order[:done], rng, tell)
        if packings.is_full().any():
            break
    return packings


def _large_first(packings: BinPackings, rng: np.random.Generator) -> list[int]:
    """Indices of the items, approximately from the largest to the smallest; those that are to lean last."""
    items = packings.items
    sizes = [float(np.log(item.shape.volume)) + rng.normal(0.0, VOLUME_SPREAD) for item in items]
    return sorted(range(len(items)), key=lambda k: (k in packings.leaning, -sizes[k]))


def _put_in(
    packings: BinPackings, k: int, others: Sequence[int], rng: np.random.Generator, tell: Callable[[], None]
) -> None:
    """Insert item k into every packing; packings without room for it become copies of others."""
    for attempt in range(MOST_TRIES):
        tell()
        packings.move(k, rng)
        if attempt >= N_TRIES and packings.holds(k).any():
            break
        if attempt >= N_TRIES and others:
            packings.move(int(rng.choice(others)), rng)  # make room
    holding, lacking = np.flatnonzero(packings.holds(k)), np.flatnonzero(~packings.holds(k))
    if len(holding) and len(lacking):
        packings.copy(of=rng.choice(holding, len(lacking)), to=lacking)


def _select(packings: BinPackings) -> None:
    """Replace the worst quarter by copies of the best quarter."""
    order, n = np.argsort(packings.cost, kind="stable"), len(packings.cost) // 4
    packings.copy(of=order[:n], to=order[-n:])
