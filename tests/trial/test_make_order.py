"""Fresh orders obey the official rules whatever the seed, and their items fit into the shelf."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.cell_file import load_cell
from pickcli.errors import InputError
from pickcli.random_scenes.make_scene import make_scene
from pickcli.seeds import derived_rng
from pickcli.trial import make_order as module
from pickcli.trial.make_order import _draw, make_order
from pickcli.trial.order import Order, OrderKind
from pickcli.trial.order_file import BINS
from pickcli.trial.output_file import order_text
from pickcli.trial.score import item_bonuses, maximum_score
from support.order_builders import parsed_order

CELL = load_cell("apc2016_delft")
ITEMS = {name for name, _ in CELL.items}
SEEDS = st.integers(0, 2**31 - 1)
KINDS = [(OrderKind.PICK, 2016), (OrderKind.STOW, 2016), (OrderKind.PICK, 2015)]

# As the rules state them, apart from the program's own tables.
ITEMS_PER_BIN = {
    (OrderKind.PICK, 2016): [1, 2, 2, 2, 3, 3, 4, 4, 4, 5, 7, 9],
    (OrderKind.STOW, 2016): [1, 1, 1, 2, 2, 2, 2, 3, 3, 5, 5, 7],
    (OrderKind.PICK, 2015): [1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 4, 4],
}
N_NAMES = {2015: 25, 2016: 39}
N_DOUBLED = {2015: 1, 2016: 7}


def copies(order: Order) -> Counter[str]:
    return Counter(name for names in (*order.bin_contents.values(), order.tote_contents) for name in names)


@pytest.mark.parametrize(("task", "year"), KINDS)
@given(seed=SEEDS)
def test_make_order_fills_the_bins_as_the_rules_say(task: OrderKind, year: int, seed: int) -> None:
    order = make_order(task, year, seed)
    assert tuple(order.bin_contents) == BINS
    assert sorted(len(names) for names in order.bin_contents.values()) == ITEMS_PER_BIN[task, year]
    assert len(order.tote_contents) == (12 if task is OrderKind.STOW else 0)


@pytest.mark.parametrize(("task", "year"), KINDS)
@given(seed=SEEDS)
def test_make_order_deals_every_copy_of_the_year_once(task: OrderKind, year: int, seed: int) -> None:
    found = copies(make_order(task, year, seed))
    assert {name for name, of in CELL.items if of == year} == set(found)
    assert len(found) == N_NAMES[year]
    assert Counter(found.values()) == {1: N_NAMES[year] - N_DOUBLED[year], 2: N_DOUBLED[year]}


@pytest.mark.parametrize("year", [2015, 2016])
@given(seed=SEEDS)
def test_make_order_names_one_target_per_bin_that_lies_in_it(year: int, seed: int) -> None:
    order = make_order(OrderKind.PICK, year, seed)
    assert tuple(target.bin for target in order.work_order) == BINS
    assert all(target.item in order.bin_contents[target.bin] for target in order.work_order)


@pytest.mark.parametrize(("task", "year"), KINDS)
@given(seed=SEEDS)
def test_make_order_writes_the_official_format(task: OrderKind, year: int, seed: int) -> None:
    order = make_order(task, year, seed)
    assert parsed_order(order_text(order), Path("fresh.json"), ITEMS) == order


@pytest.mark.parametrize(("task", "year"), KINDS)
@given(seed=SEEDS)
def test_make_order_depends_on_the_seed_alone(task: OrderKind, year: int, seed: int) -> None:
    order = make_order(task, year, seed)
    assert make_order(task, year, seed) == order
    assert make_order(task, year, seed ^ 1) != order


@pytest.mark.parametrize(("task", "year"), KINDS)
@given(seed=SEEDS)
def test_make_order_leaves_half_of_each_bin_free(task: OrderKind, year: int, seed: int) -> None:
    contents = make_order(task, year, seed).bin_contents
    assert tuple(contents) == BINS and any(contents.values())
    for name, items in contents.items():
        cell_bin = CELL.pod.bins[name]
        width = cell_bin.room.y_range[1] - cell_bin.room.y_range[0]
        height = cell_bin.room.ceiling_back - cell_bin.room.floor_back
        boxes = sum(float(np.prod(CELL.item(item, year).shape.extents)) for item in items)
        assert boxes <= 0.5 * cell_bin.room.depth * width * height


def test_make_order_draws_again_only_what_is_too_full() -> None:
    """Seed 50261 dealt nine items of 18.7 litres to a bin of 27; seed 7 dealt nothing of the kind."""
    full, easy = (make_order(OrderKind.PICK, 2016, seed) for seed in (50261, 7))
    assert "hanes_tube_socks" not in full.bin_contents["bin_G"]
    assert easy == _draw(OrderKind.PICK, 2016, derived_rng("order", "pick", 2016, 7))


def test_every_item_passes_every_mouth_in_some_orientation() -> None:
    """So no bin has to be drawn again for the size of an item alone."""
    assert CELL.pod.bins and CELL.items
    for cell_bin in CELL.pod.bins.values():
        for item in CELL.items.values():
            thin, middle, long = sorted(item.shape.extents)
            mouth = sorted((cell_bin.access.width, cell_bin.access.height))
            assert thin < mouth[0] and middle < mouth[1] and long < cell_bin.room.depth


@given(seed=SEEDS)
def test_maximum_score_is_that_of_official_orders(seed: int) -> None:
    """12 targets in 4 bins of one or two, 5 of three or four, 3 of five or more, and the bonuses."""
    order = make_order(OrderKind.PICK, 2016, seed)
    best = maximum_score(order, item_bonuses(CELL, order))
    base = 4 * 10 + 5 * 15 + 3 * 20
    assert base <= best <= base + 12 * 3


def test_every_bin_and_every_copy_is_drawn_by_some_seed() -> None:
    orders = [make_order(OrderKind.PICK, 2016, seed) for seed in range(300)]
    assert {target.item for order in orders for target in order.work_order} == set(copies(orders[0]))
    assert {b for order in orders for b, names in order.bin_contents.items() if len(names) == 9} == set(BINS)


@pytest.mark.parametrize(
    ("task", "year"), [(OrderKind.STOW, 2015), (OrderKind.OUTPUT, 2016), (OrderKind.PICK, 2017)]
)
def test_make_order_refuses_tasks_that_never_were(task: OrderKind, year: int) -> None:
    with pytest.raises(InputError, match=f"no {task} task in {year}.*pick 2016, stow 2016"):
        make_order(task, year, 0)


@pytest.mark.slow
@pytest.mark.parametrize(("task", "year"), KINDS)
def test_make_scene_stows_fresh_orders(task: OrderKind, year: int) -> None:
    order = make_order(task, year, seed=101)
    scene = make_scene(order.bin_contents, CELL, 101, year)
    assert scene.items
    for bin_name, names in order.bin_contents.items():
        assert Counter(placed.item.name for placed in scene.in_location(bin_name)) == Counter(names)


def test_an_order_that_fits_in_no_way_is_not_drawn_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MOST_FULL", 0.01)
    monkeypatch.setattr(module, "MOST_DRAWS", 5)
    with pytest.raises(InputError, match="pick 2016: each of 5 orders drawn fills a bin by more than 1 %"):
        make_order(OrderKind.PICK, 2016, 1)
