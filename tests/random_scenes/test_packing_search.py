"""Fillings: everything inside, nothing in anything else, order kept, the same for the same seed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.cell_file import load_cell
from pickcli.random_scenes.bin_packings import BLOCKED, BinPackings
from pickcli.random_scenes.box_arrays import BoxArrays
from pickcli.random_scenes.crowding_cost import crowding
from pickcli.random_scenes.extraction_access import have_way_out
from pickcli.random_scenes.packing_search import fill
from pickcli.random_scenes.placement_sampling import RAISED

CELL = load_cell("apc2016_delft")
# Any four of these fit into any bin.
NAMES = sorted(i.name for i in CELL.items.values() if i.year == 2016 and i.shape.volume < 1.2e-3)


def filled(bin_name: str, names: list[str], seed: int, may_raise: bool = False) -> BinPackings:
    items = [CELL.item(name) for name in names]
    return fill(CELL.pod.bins[bin_name], items, np.random.default_rng(seed), may_raise)


def best_of(packings: BinPackings) -> int:
    return int(np.argmin(np.where(packings.is_full(), packings.cost, np.inf)))


@given(
    st.sampled_from(sorted(CELL.pod.bins)),
    st.lists(st.sampled_from(NAMES), min_size=1, max_size=4),
    st.integers(0, 10**6),
)
@settings(max_examples=12, deadline=None)
def test_full_ones_hold_everything_inside_and_apart(bin_name: str, names: list[str], seed: int) -> None:
    cell_bin, packings = CELL.pod.bins[bin_name], filled(bin_name, names, seed)
    assert packings.is_full().any()
    boxes = packings.lying.boxes[packings.is_full()]
    assert np.all(boxes.low[..., 0] > 0.0) and np.all(boxes.high[..., 0] < cell_bin.room.depth)
    assert np.all(boxes.low[..., 1] > cell_bin.room.y_range[0]) and np.all(
        boxes.high[..., 1] < cell_bin.room.y_range[1]
    )
    assert np.all(boxes.high[..., 2] < cell_bin.room.ceiling_back)
    one, other = boxes.column, boxes.row
    apart = np.maximum(one.low - other.high, other.low - one.high).max(axis=-1)
    on_floor = packings.lying.own[packings.is_full()] < RAISED
    both = on_floor[:, :, None] & on_floor[:, None, :] & ~np.eye(len(names), dtype=bool)
    assert np.all(apart[both] >= 0.003 - 1e-9)
    # What lies on something tilted may sink into the box around that, not into the thing itself.
    assert np.all(apart[:, ~np.eye(len(names), dtype=bool)] > -0.025)


@given(st.lists(st.sampled_from(NAMES), min_size=1, max_size=4), st.integers(0, 10**6))
@settings(max_examples=6, deadline=None)
def test_the_boxes_are_around_the_items_where_they_lie(names: list[str], seed: int) -> None:
    packings = filled("bin_B", names, seed)
    k = best_of(packings)
    for item, T, low, high in zip(
        packings.items,
        packings.poses(k),
        packings.lying.boxes.low[k],
        packings.lying.boxes.high[k],
        strict=True,
    ):
        reach = item.shape.reach(T[:3, :3])
        np.testing.assert_allclose(T[:3, 3] - reach, low, atol=1e-12)
        np.testing.assert_allclose(T[:3, 3] + reach, high, atol=1e-12)
        np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-12)


def test_the_cost_kept_is_the_cost_there_is() -> None:
    packings = filled("bin_C", ["jane_eyre_dvd", "crayola_24_ct", "kleenex_tissue_box"], 5)
    boxes, own = packings.lying.boxes, packings.lying.own.sum(axis=1)
    blocked = (~have_way_out(packings.cell_bin, boxes)).sum(axis=-1)
    expected = own + crowding(packings.cell_bin, boxes) + BLOCKED * blocked
    full = packings.is_full() & ~packings.is_cramming
    assert full.any()
    np.testing.assert_allclose(packings.cost[full], expected[full], atol=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_with_room_everything_lies_on_the_floor_and_comes_out(seed: int) -> None:
    packings = filled("bin_E", ["crayola_24_ct", "kleenex_tissue_box", "dove_beauty_bar"], seed)
    boxes = packings.lying.boxes[best_of(packings)]
    assert have_way_out(packings.cell_bin, boxes).all()
    assert np.all(boxes.low[:, 2] < packings.cell_bin.room.floor_front)


def test_one_seed_one_filling_and_another_another() -> None:
    names = ["crayola_24_ct", "command_hooks", "staples_index_cards"]
    a, b, c = (filled("bin_H", names, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(a.lying.centre, b.lying.centre)
    np.testing.assert_array_equal(a.cost, b.cost)
    moved = a.poses(best_of(a))[:, :2, 3] - c.poses(best_of(c))[:, :2, 3]
    assert np.linalg.norm(moved, axis=1).max() > 0.01


def test_what_does_not_fit_is_left_outside() -> None:
    packings = filled("bin_H", ["hanes_tube_socks"] * 6, 1)
    assert not packings.is_full().any()
    assert np.all((packings.lying.boxes.low[..., 0] > 1.0) == (packings.lying.own >= 1000.0))


@pytest.mark.parametrize("seed", range(3))
def test_socks_beside_paper_towels_are_raised_inside_where_they_may_be(seed: int) -> None:
    """200 mm lying beside 150 mm is more than the 272 mm of the bin; standing they are 100 mm wide."""
    names = ["hanes_tube_socks", "kleenex_paper_towels", "dove_beauty_bar"]
    assert not filled("bin_D", names, seed).is_full().any()
    packings = filled("bin_D", names, seed, may_raise=True)
    assert packings.is_full().any()
    socks = packings.lying.boxes[packings.is_full()][:, 0]
    np.testing.assert_allclose((socks.high - socks.low)[:, 2], 0.2, atol=0.03)


@given(
    st.sampled_from(sorted(CELL.pod.bins)),
    st.lists(st.sampled_from(sorted(i.name for i in CELL.items.values() if i.year == 2016)), max_size=3),
    st.booleans(),
    st.integers(0, 10**6),
)
@settings(max_examples=12, deadline=None)
def test_what_stands_higher_than_the_mouth_was_tipped_up_under_the_ceiling(
    bin_name: str, names: list[str], may_raise: bool, seed: int
) -> None:
    names = [*names, "hanes_tube_socks"]
    cell_bin, packings = CELL.pod.bins[bin_name], filled(bin_name, names, seed, may_raise)
    for of in np.flatnonzero(packings.is_full()):
        for item, T in zip(packings.items, packings.poses(int(of)), strict=True):
            up = int(np.abs(T[2, :3]).argmax())
            height, thin = item.shape.extents[up], item.shape.extents.min()
            if height > cell_bin.access.height:
                assert may_raise
                assert np.hypot(height, thin) < cell_bin.room.ceiling_back - cell_bin.room.floor_back
                assert np.median(item.shape.extents) <= cell_bin.access.width


def _pair(front: float, back: float) -> BoxArrays:
    low = np.array([[0.05, -0.05, -0.03], [0.25, -0.05, -0.03]])
    return BoxArrays(low, low + np.array([[0.1, 0.1, front], [0.1, 0.1, back]]))


def test_tall_things_belong_behind_low_ones() -> None:
    cell_bin = CELL.pod.bins["bin_E"]
    right, wrong, level = (
        crowding(cell_bin, _pair(*pair)) for pair in ((0.02, 0.1), (0.1, 0.02), (0.02, 0.02))
    )
    assert right == level < wrong


def test_crowding_does_not_depend_on_the_order_of_things() -> None:
    packings = filled("bin_H", ["crayola_24_ct", "command_hooks", "jane_eyre_dvd", "scotch_duct_tape"], 3)
    boxes = packings.lying.boxes
    shuffled = BoxArrays(boxes.low[:, [2, 0, 3, 1]], boxes.high[:, [2, 0, 3, 1]])
    np.testing.assert_allclose(
        crowding(packings.cell_bin, boxes), crowding(packings.cell_bin, shuffled), atol=1e-12
    )
