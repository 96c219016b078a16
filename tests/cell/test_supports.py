"""What rests on what, and what falls or rolls without it: cases whose answer is plain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.load import load_cell
from pickcli.cell.model import Cell
from pickcli.cell.scene import PlacedItem, PoseNoise, Scene
from pickcli.cell.supports import Supports, supports_of
from pickcli.geometry import pose

BIN = "bin_E"
EXACT, NOISY = PoseNoise(), PoseNoise(0.002, float(np.radians(1.0)))
SLOPE_FROM = 0.02  # x in the bin where the sloping part of its floor begins, behind the lip


@pytest.fixture(scope="module")
def cell() -> Cell:
    return load_cell("apc2016_delft")


def put(
    cell: Cell, name: str, x: float, y: float, z: float = 0.0, rpy: tuple[float, float, float] = (0, 0, 0)
) -> PlacedItem:
    """An item whose lowest point is z over the back part of the floor, in the bin's frame."""
    cell_bin, item = cell.pod.bins[BIN], cell.item(name)
    low = float(item.shape.reach(pose(rpy=rpy)[:3, :3])[2])
    T = pose([x, y, cell_bin.floor_back + z + low], rpy=rpy)
    return PlacedItem(name, item, BIN, cell.T_world_pod @ cell_bin.T_pod_bin @ T)


def of(cell: Cell, *items: PlacedItem, noise: PoseNoise = EXACT) -> Supports:
    return supports_of(Scene(cell, cell.T_world_pod, items, noise))


def height(cell: Cell, name: str) -> float:
    return float(cell.item(name).shape.extents[2])


@pytest.mark.parametrize("noise", [EXACT, NOISY])
def test_what_lies_on_another_falls_without_it_and_not_the_other_way(cell: Cell, noise: PoseNoise) -> None:
    box = put(cell, "kleenex_tissue_box", 0.25, 0.0)
    book = put(cell, "i_am_a_bunny_book", 0.25, 0.0, height(cell, box.id))
    supports = of(cell, box, book, noise=noise)
    assert supports.carriers(book.id) == (box.id,)
    assert supports.lying_on(box.id) == (book.id,)
    assert supports.falling(box.id) == (book.id,)
    assert supports.falling(book.id) == ()
    assert supports.stays(box.id, {book.id}) and not supports.stays(book.id, {box.id})


def test_of_a_stack_the_top_must_go_first(cell: Cell) -> None:
    z, stack = 0.0, []
    for name in ("kleenex_tissue_box", "i_am_a_bunny_book", "dove_beauty_bar"):
        stack.append(put(cell, name, 0.25, 0.0, z))
        z += height(cell, name)
    assert of(cell, *stack).falling("kleenex_tissue_box") == ("dove_beauty_bar", "i_am_a_bunny_book")


@pytest.mark.parametrize(("y", "stays"), [(0.0, True), (0.045, False)])
def test_what_lies_partly_on_the_target_blocks_whether_it_would_stay_or_not(
    cell: Cell, y: float, stays: bool
) -> None:
    """A book over a wide box in the middle and a bar beside it."""
    box = put(cell, "cherokee_easy_tee_shirt", 0.25, -0.05)
    bar = put(cell, "crayola_24_ct", 0.25, 0.09)
    book = put(cell, "i_am_a_bunny_book", 0.25, y, 0.025, (0, 0, np.pi / 2))
    supports = of(cell, box, bar, book)
    assert set(supports.carriers(book.id)) == {box.id, bar.id}
    assert supports.stays(book.id, {bar.id}) is stays
    assert supports.falling(bar.id) == supports.falling(box.id) == (book.id,)


def test_what_leans_falls_and_what_stands_beside_stays(cell: Cell) -> None:
    box = put(cell, "kleenex_tissue_box", 0.25, 0.0)
    reach = 0.115 / 2
    beside = put(cell, "dove_beauty_bar", 0.25, reach + 0.033)
    lean = 0.65  # rad off upright, its upper edge against the box
    thin, tall = 0.014, 0.135
    y = -(reach + np.sin(lean) * tall / 2 + np.cos(lean) * thin / 2)
    leaning = put(cell, "jane_eyre_dvd", 0.25, y, 0.0, (np.pi / 2 - lean, 0.0, 0.0))
    supports = of(cell, box, beside, leaning)
    assert {c.b for c in supports.touching[box.id]} >= {beside.id, leaning.id}
    assert supports.falling(box.id) == (leaning.id,)
    assert supports.rolling(box.id) == ()


def test_a_ball_beside_rolls_down_a_slope_and_stays_on_the_level(cell: Cell) -> None:
    radius = 0.034
    box = put(cell, "kleenex_tissue_box", 0.25, 0.0)
    level = put(cell, "rawlings_baseball", 0.25, 0.115 / 2 + radius)
    supports = of(cell, box, level)
    assert supports.falling(box.id) == () and supports.rolling(box.id) == (level.id,)
    cell_bin = cell.pod.bins[BIN]
    x = cell_bin.floor_flat_from - 0.05
    front = float(
        np.interp(x, [SLOPE_FROM, cell_bin.floor_flat_from], [cell_bin.floor_front, cell_bin.floor_back])
    )
    slope = np.arctan2(cell_bin.floor_front - cell_bin.floor_back, cell_bin.floor_flat_from - SLOPE_FROM)
    at = pose([x, 0.0, front + radius / np.cos(slope)])
    ball = replace(level, T_world_item=cell.T_world_pod @ cell_bin.T_pod_bin @ at)
    behind = put(cell, "kleenex_tissue_box", x + radius + 0.0655, 0.0)
    supports = of(cell, ball, behind)
    assert supports.falling(behind.id) == (ball.id,)
    assert supports.rolling(behind.id) == ()
    assert supports.falling(ball.id) == ()


def test_what_seems_to_hang_in_the_air_lies_on_what_is_below(cell: Cell) -> None:
    box = put(cell, "kleenex_tissue_box", 0.25, 0.0)
    book = put(cell, "i_am_a_bunny_book", 0.25, 0.0, height(cell, box.id) + 0.03)
    supports = of(cell, box, book)
    assert supports.carriers(book.id) == (box.id,)
    assert supports.falling(box.id) == (book.id,)


def test_a_board_is_between_items_of_two_bins(cell: Cell) -> None:
    box = put(cell, "kleenex_tissue_box", 0.25, 0.0)
    other = replace(put(cell, "i_am_a_bunny_book", 0.25, 0.0, height(cell, box.id)), location="bin_B")
    assert of(cell, box, other).falling(box.id) == ()


def test_noise_makes_neighbours_that_may_touch(cell: Cell) -> None:
    box = put(cell, "kleenex_tissue_box", 0.25, 0.0)
    beside = put(cell, "dove_beauty_bar", 0.25, 0.115 / 2 + 0.033 + 0.004)
    assert beside.id not in {c.b for c in of(cell, box, beside).touching[box.id]}
    assert beside.id in {c.b for c in of(cell, box, beside, noise=NOISY).touching[box.id]}


def test_every_contact_is_seen_from_both_sides(cell: Cell) -> None:
    box = put(cell, "kleenex_tissue_box", 0.25, 0.0)
    book = put(cell, "i_am_a_bunny_book", 0.26, 0.01, height(cell, box.id))
    touching = of(cell, box, book).touching
    (one,) = [c for c in touching[box.id] if c.b == book.id]
    (other,) = [c for c in touching[book.id] if c.b == box.id]
    assert one.gap == other.gap
    np.testing.assert_array_equal(one.normal, -other.normal)
