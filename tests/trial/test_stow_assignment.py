"""Which bin each item of a stow is meant for, and why."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pickcli.cell.cell import Cell
from pickcli.trial.order import Order, OrderKind
from pickcli.trial.order_file import BINS
from pickcli.trial.score import item_bonuses
from pickcli.trial.stow_assignment import FULL_SHARE, StowChoice, StowRule, assign_bins

CARDS, SOCKS, TISSUES = "staples_index_cards", "hanes_tube_socks", "kleenex_tissue_box"


def stow(*tote: str, **bins: tuple[str, ...]) -> Order:
    return Order(OrderKind.STOW, 2016, {name: bins.get(name, ()) for name in BINS}, tote, ())


def assign(order: Order, cell: Cell, rule: StowRule = StowRule.POINTS) -> tuple[StowChoice, ...]:
    return assign_bins(order, cell, item_bonuses(cell, order), [cell.robot.tool], rule)


def chosen(order: Order, cell: Cell, rule: StowRule = StowRule.POINTS) -> dict[str, StowChoice]:
    return {choice.item: choice for choice in assign(order, cell, rule)}


def test_bins_that_started_fuller_come_first(cell: Cell) -> None:
    order = stow(CARDS, bin_B=(CARDS,) * 3, bin_H=(CARDS,) * 5, bin_K=(CARDS,))
    (choice,) = assign(order, cell)
    assert choice.bins[:2] == ("bin_H", "bin_B") and set(choice.bins) == set(BINS)
    assert choice.points == 20 and choice.reason.startswith("bin_H started with 5, ")


def test_the_smallest_items_get_the_room_of_the_fullest_bin(cell: Cell) -> None:
    room = cell.places["bin_E"].room.volume
    large, small = (float(cell.item(name).shape.extents.prod()) for name in (TISSUES, CARDS))
    n = int((FULL_SHARE * room - small) / large)
    order = stow(
        TISSUES, CARDS, bin_E=(TISSUES,) * n + (CARDS,) * int((FULL_SHARE * room - n * large) / small - 1)
    )
    choices = chosen(order, cell)
    assert choices[CARDS].bins[0] == "bin_E" and choices[CARDS].points == 20
    assert choices[TISSUES].bins[0] != "bin_E" and choices[TISSUES].points == 10
    assert "bin_E would be over 50 %" in choices[TISSUES].reason
    assert choices[TISSUES].bins[-1] == "bin_E"  # it is asked all the same, in the end


def test_by_the_rule_of_kth_the_biggest_go_to_the_biggest_bins(cell: Cell) -> None:
    order = stow(CARDS, SOCKS, bin_E=(CARDS,) * 5)
    by_size = assign(order, cell, StowRule.SIZE)
    assert [choice.item for choice in by_size] == [SOCKS, CARDS]
    volumes = [cell.places[choice.bins[0]].room.volume for choice in by_size]
    assert volumes[0] == pytest.approx(max(cell.places[name].room.volume for name in BINS), rel=1e-3)


def test_what_fits_into_no_bin_is_told(cell: Cell) -> None:
    shape = cell.item(SOCKS).shape
    large = replace(cell.item(SOCKS), shape=replace(shape, size=tuple(9 * size for size in shape.size)))
    wide = replace(cell, items={**cell.items, (SOCKS, 2016): large})
    (choice,) = assign(stow(SOCKS), wide)
    assert choice.bins == () and choice.points == 0 and "no bin is large enough" in choice.reason


def test_the_same_order_gives_the_same_assignment(cell: Cell) -> None:
    order = stow(CARDS, CARDS, SOCKS, TISSUES, bin_B=(CARDS,) * 3, bin_H=(CARDS,) * 5)
    assert assign(order, cell) == assign(order, cell)


def test_what_no_tool_can_hold_comes_last_and_takes_no_room(cell: Cell) -> None:
    dumbbell = "fitness_gear_3lb_dumbbell"
    with_it, alone = stow(dumbbell, TISSUES, bin_E=(CARDS,) * 5), stow(TISSUES, bin_E=(CARDS,) * 5)
    tissues, unheld = assign(with_it, cell)
    assert (unheld.item, unheld.points, unheld.can_be_held) == (dumbbell, 0, False)
    assert "no tool can hold it: needs pinching" in unheld.reason
    assert (tissues,) == assign(alone, cell)
