"""Random orders by the official rules, from a seed.

The rules of 2016 are those of Amazon's generator: numbers of items by bin, items with two copies, one target
per bin, twelve items in the tote of a stow. The rules of 2015 have only lower bounds (at least two bins each
with one, two, and three or more items); the numbers are those of the example that the teams shared. Sources
are in docs/formats/order.md.

An order with a bin that is hard to stow is drawn again as a whole.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.errors import InputError
from pickcli.seeds import derived_rng
from pickcli.trial.order import Order, OrderKind, Target
from pickcli.trial.order_file import BINS

YEARS = (2015, 2016)

# Number of bins by number of items; of a stow before one item of each bin goes into the tote.
BIN_SIZES: Mapping[tuple[OrderKind, int], Mapping[int, int]] = {
    (OrderKind.PICK, 2015): {1: 4, 2: 4, 3: 2, 4: 2},
    (OrderKind.PICK, 2016): {1: 1, 2: 3, 3: 2, 4: 3, 5: 1, 7: 1, 9: 1},
    (OrderKind.STOW, 2016): {2: 3, 3: 4, 4: 2, 6: 2, 8: 1},
}

MOST_FULL = 0.5  # share of a bin's volume filled by the items' boxes; most fuller bins cannot be stowed
MOST_DRAWS = 1000  # a single draw succeeds in 95 of 100 cases
KIVA_POD = "apc2016_delft"  # cell with the pod used in both years

TWO_COPIES: Mapping[int, tuple[str, ...]] = {
    2015: ("mead_index_cards",),
    2016: (
        "creativity_chenille_stems",
        "dasani_water_bottle",
        "elmers_washable_no_run_school_glue",
        "expo_dry_erase_board_eraser",
        "scotch_bubble_mailer",
        "scotch_duct_tape",
        "staples_index_cards",
    ),
}


def make_order(task: OrderKind, year: int, seed: int) -> Order:
    """Draw a random order by the official rules of a task and year.

    A pick has one target per bin, in the order of the bins; a stow has one item of each bin in the tote. No
    bin is fuller than MOST_FULL.

    Args:
        task: PICK or STOW; in 2015 there was no stow.
        year: 2015 or 2016.
        seed: Seed of all randomness, together with task and year.

    Returns:
        An order with all items of the year, and the numbers of items by bin that the rules prescribe.

    Raises:
        InputError: There was no such task, or the items do not fit in the bins.
    """
    if (task, year) not in BIN_SIZES:
        raise InputError(f"there was no {task} task in {year}; take one of {', '.join(tasks())}")
    rng = derived_rng("order", str(task), year, seed)
    for _ in range(MOST_DRAWS):
        order = _draw(task, year, rng)
        if all(share_filled(name, names, year) <= MOST_FULL for name, names in order.bin_contents.items()):
            return order
    raise InputError(
        f"{task} {year}: each of {MOST_DRAWS} orders drawn fills a bin by more than {100 * MOST_FULL:g} % of "
        f"its volume; have the items under data/items, or the bins of {KIVA_POD}, been changed?"
    )


def share_filled(bin_name: str, names: Sequence[str], year: int) -> float:
    """Compute the share of a bin's clear volume filled by the items' boxes.

    Args:
        bin_name: Name of the bin.
        names: Names of the items.
        year: 2015 or 2016, for the items' figures.

    Returns:
        The share, 0 to 1.
    """
    cell = _cell()
    boxes = [float(np.prod(cell.item(name, year).shape.extents)) for name in names]
    return sum(boxes) / cell.pod.bins[bin_name].room.volume


@cache
def _cell() -> Cell:
    return load_cell(KIVA_POD)


def _draw(task: OrderKind, year: int, rng: np.random.Generator) -> Order:
    """Draw an order that follows the rules for numbers, without regard to volume."""
    contents = _contents(BIN_SIZES[task, year], _copies(year), rng)
    drawn = {name: names[int(rng.integers(len(names)))] for name, names in contents.items()}
    if task is OrderKind.PICK:
        work_order = tuple(Target(name, item) for name, item in drawn.items())
        return Order(task, year, contents, (), work_order)
    left = {name: _without(names, drawn[name]) for name, names in contents.items()}
    return Order(task, year, left, tuple(drawn.values()), ())


def tasks() -> tuple[str, ...]:
    """List all tasks that existed.

    Returns:
        Each as "pick 2016".
    """
    return tuple(f"{task} {year}" for task, year in BIN_SIZES)


def _copies(year: int) -> list[str]:
    """Names of all items of a year, repeated for each copy."""
    names = sorted(name for name, of in _cell().items if of == year)
    return sorted([*names, *TWO_COPIES[year]])


def _contents(
    sizes: Mapping[int, int], copies: list[str], rng: np.random.Generator
) -> dict[str, tuple[str, ...]]:
    """Deal all copies to the bins, after drawing the number of items of each bin."""
    numbers = rng.permutation([size for size, n_bins in sizes.items() for _ in range(n_bins)])
    dealt = rng.permutation(np.array(copies))
    assert len(numbers) == len(BINS) and numbers.sum() == len(dealt)
    parts = np.split(dealt, np.cumsum(numbers)[:-1])
    return {name: tuple(map(str, part)) for name, part in zip(BINS, parts, strict=True)}


def _without(names: tuple[str, ...], one: str) -> tuple[str, ...]:
    """Remove one copy of a name."""
    i = names.index(one)
    return names[:i] + names[i + 1 :]
