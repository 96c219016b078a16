"""The real orders that come with the product are read, and are worth what such orders are worth."""

from __future__ import annotations

from pathlib import Path

import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.errors import InputError, UnknownNameError
from pickcli.trial.order import OrderKind
from pickcli.trial.order_file import order_names, read_order
from pickcli.trial.output_file import order_text
from pickcli.trial.score import item_bonuses, maximum_score
from support.order_builders import parsed_order

TASKS = Path(__file__).parents[2] / "data" / "tasks"
CELL = load_cell("apc2016_delft")
STREAMS = ("pr2_belt_moving", "pr2_belt_static")
COMMISSIONS = ("apple_commission", "apple_belts_commission", "apple_cluster_commission")
OTHERS = (*STREAMS, *COMMISSIONS)
FILES = sorted(path for path in TASKS.glob("*.json") if path.stem not in OTHERS)


def test_there_are_five_pick_orders_of_2016() -> None:
    orders = [read_order(path, CELL) for path in FILES]
    assert sum(o.kind is OrderKind.PICK and o.year == 2016 for o in orders) == 5
    assert sum(o.kind is OrderKind.STOW for o in orders) == 5


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_real_orders_are_read_and_survive_writing(path: Path) -> None:
    order = read_order(path, CELL)
    names = {name for name, _ in CELL.items}
    assert parsed_order(order_text(order), Path("copy.json"), names) == order
    n_items = sum(len(names) for names in order.bin_contents.values())
    if order.kind is OrderKind.PICK:
        assert len(order.work_order) == len({t.bin for t in order.work_order}) == 12
    else:
        assert len(order.tote_contents) == 12
    if order.year == 2016:
        assert n_items + len(order.tote_contents) == 46
    else:
        assert n_items == 26


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_maxima_are_those_of_the_challenge(path: Path) -> None:
    order = read_order(path, CELL)
    best = maximum_score(order, item_bonuses(CELL, order))
    if order.kind is OrderKind.STOW:
        assert 12 * 20 <= best <= 12 * 20 + 18  # a bin of five or more is always there
    elif order.year == 2016:
        assert 178 <= best <= 201  # the range of the official pick files
    else:
        assert best <= 190


def test_a_missing_order_is_an_input_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_order(tmp_path / "no.json", CELL)


def test_orders_that_come_with_the_package_go_by_name() -> None:
    assert order_names() == [path.stem for path in FILES]
    for path in FILES:
        assert read_order(Path(path.stem), CELL) == read_order(path, CELL)


def test_a_name_of_no_order_is_told_the_nearest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(
        UnknownNameError, match="unknown order 'jsk_pick_simple'; did you mean 'jsk_pick_sample'"
    ):
        read_order(Path("jsk_pick_simple"), CELL)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "jsk_pick_sample").write_text(order_text(read_order(FILES[0], CELL)))  # a file comes first
    assert read_order(Path("jsk_pick_sample"), CELL) == read_order(FILES[0], CELL)
