"""Packing search: fill a bin as people do, the large things first, then tidied until it looks right.

A bounded search, counted and never timed: packings are begun at random and improved by moving one thing at a
time, at first also for the worse; now and then the worst are given up for copies of the best.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.stowing.bin_packings import BinPackings

N_PACKINGS = 16
N_ROUNDS = 4  # attempts, at most, to put everything in
N_TRIES = 8  # moves with which an item is put in
MOST_TRIES = 60  # moves with which an item is put in that fits nowhere yet
VOLUME_SPREAD = 0.3  # how far the order differs from large to small, in the logarithm of the volume
N_MOVES = 30  # per item at most, after everything is in
SELECTION = 25  # moves between selections
TOLERANCE = 3.0  # by which a move may make things worse at first
STRICT_FROM = 2 / 3  # of the moves, from where on it may not
GOOD = 0.3  # cost after which no better is sought


def fill(
    cell_bin: Place,
    items: Sequence[Item],
    rng: np.random.Generator,
    may_raise: bool = False,
    tell: Callable[[], None] = lambda: None,
) -> BinPackings:
    """Search packings of a bin.

    Args:
        cell_bin: The bin.
        items: What is to be put in.
        rng: Source of random numbers.
        may_raise: Whether things may stand higher than the mouth, brought in lying and raised inside.
        tell: Called before every step of the search; decides nothing.

    Returns:
        Packings, in no order; those that are not full lack what found no room.
    """
    packings = _all_in(cell_bin, items, may_raise, rng, tell)
    n_moves = N_MOVES * len(items) if packings.is_full().any() else 0
    for k in range(n_moves):
        tell()
        packings.tidy_up()
        if packings.cost[packings.is_full()].min(initial=np.inf) <= GOOD:
            break
        tolerance = TOLERANCE * max(0.0, 1.0 - k / (STRICT_FROM * n_moves))
        packings.move(int(rng.integers(len(items))), rng, tolerance)
        if k % SELECTION == SELECTION - 1:
            _select(packings)
    return packings


def _all_in(
    cell_bin: Place,
    items: Sequence[Item],
    may_raise: bool,
    rng: np.random.Generator,
    tell: Callable[[], None],
) -> BinPackings:
    """Packings that are begun again, a limited number of times, until everything is in."""
    for _ in range(N_ROUNDS):
        packings = BinPackings.empty(cell_bin, items, N_PACKINGS, may_raise)
        order = _large_first(items, rng)
        for done, k in enumerate(order):
            _put_in(packings, k, order[:done], rng, tell)
        if packings.is_full().any():
            break
    return packings


def _large_first(items: Sequence[Item], rng: np.random.Generator) -> list[int]:
    """Numbers of the items, about from the largest to the smallest."""
    sizes = [float(np.log(item.shape.volume)) + rng.normal(0.0, VOLUME_SPREAD) for item in items]
    return sorted(range(len(items)), key=lambda k: -sizes[k])


def _put_in(
    packings: BinPackings, k: int, others: Sequence[int], rng: np.random.Generator, tell: Callable[[], None]
) -> None:
    """Put item k into every packing; one without room for it becomes a copy of one with room."""
    for attempt in range(MOST_TRIES):
        tell()
        packings.move(k, rng)
        if attempt >= N_TRIES and packings.holds(k).any():
            break
        if attempt >= N_TRIES and others:
            packings.move(int(rng.choice(others)), rng)  # it has to make room
    holding, lacking = np.flatnonzero(packings.holds(k)), np.flatnonzero(~packings.holds(k))
    if len(holding) and len(lacking):
        packings.copy(of=rng.choice(holding, len(lacking)), to=lacking)


def _select(packings: BinPackings) -> None:
    """Replace the worst quarter by copies of the best."""
    order, n = np.argsort(packings.cost, kind="stable"), len(packings.cost) // 4
    packings.copy(of=order[:n], to=order[-n:])
