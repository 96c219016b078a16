"""What rests on what, and what falls or rolls without it: cases whose answer is plain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.displacement import Displacement
from pickcli.cell.item import Item
from pickcli.cell.load import load_cell
from pickcli.cell.model import Cell
from pickcli.cell.scene import PlacedItem, PoseNoise, Scene
from pickcli.cell.shapes import Shape, ShapeKind
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


def shaped(cell: Cell, size: tuple[float, ...], kind: ShapeKind = ShapeKind.BOX, mass: float = 0.2) -> Item:
    """An item of any shape, as heavy as told."""
    return replace(cell.item("crayola_24_ct"), shape=Shape(kind, size), mass=mass)


def at(
    cell: Cell, name: str, item: Item, x: float, y: float, z: float, rpy: tuple[float, ...] = (0, 0, 0)
) -> PlacedItem:
    """An item with its middle z over the back part of the floor, in the bin's frame."""
    cell_bin = cell.pod.bins[BIN]
    T = pose([x, y, cell_bin.floor_back + z], rpy=rpy)
    return PlacedItem(name, item, BIN, cell.T_world_pod @ cell_bin.T_pod_bin @ T)


@pytest.mark.parametrize("angle", [0.0, 1.0])
@pytest.mark.parametrize("yaw", [0.0, np.pi / 2, np.pi / 4])
def test_a_board_on_its_edge_stands_if_no_tilt_of_the_world_throws_it_over(
    cell: Cell, angle: float, yaw: float
) -> None:
    """One degree, and what its pose may be off: its middle 80 mm high must stay over its foot."""
    noise, least = PoseNoise(0.0, float(np.radians(angle))), 0.16 * np.tan(np.radians(1.0 + angle))
    for width, stands in ((least + 0.0004, True), (least - 0.0004, False)):
        board = at(cell, "board", shaped(cell, (width, 0.1, 0.16)), 0.3, 0.0, 0.08, (0.0, 0.0, yaw))
        assert of(cell, board, noise=noise).stays("board") is stands


@pytest.mark.parametrize("direction", [(1, 0), (-1, 0), (0, 1), (0, -1)])
def test_what_overhangs_stays_while_its_middle_is_over_what_carries_it(
    cell: Cell, direction: tuple[int, int]
) -> None:
    """And over it still when the world is tilted by a degree: 30 mm high, that is half a millimetre."""
    below = at(cell, "below", shaped(cell, (0.1, 0.1, 0.05)), 0.3, 0.0, 0.025)
    for short, stays in ((0.0008, True), (0.0003, False)):
        x, y = ((0.05 - short) * d for d in direction)
        above = at(cell, "above", shaped(cell, (0.06, 0.06, 0.06)), 0.3 + x, y, 0.08)
        supports = of(cell, below, above)
        assert supports.carriers("above") == ("below",)
        assert supports.stays("above") is stays


def test_what_carries_an_item_counts_as_smaller_by_what_both_poses_may_be_off(cell: Cell) -> None:
    below = at(cell, "below", shaped(cell, (0.1, 0.1, 0.05)), 0.3, 0.0, 0.025)
    for short, stays in ((0.0048, True), (0.0042, False)):
        above = at(cell, "above", shaped(cell, (0.06, 0.06, 0.06)), 0.35 - short, 0.0, 0.08)
        assert of(cell, below, above, noise=PoseNoise(0.002, 0.0)).stays("above") is stays


def on_a_slope(cell: Cell, degrees: float, x: float, z: float) -> tuple[PlacedItem, PlacedItem]:
    """A box that is pitched, with its middle at x and z m in the bin, and a smaller one flat on it."""
    turn = (0.0, float(np.radians(degrees)), 0.0)
    below = at(cell, "below", shaped(cell, (0.12, 0.1, 0.05)), x, 0.0, z, turn)
    T = below.T_world_item @ pose((0.0, 0.0, 0.04))
    return below, PlacedItem("above", shaped(cell, (0.05, 0.05, 0.03)), BIN, T)


@pytest.mark.parametrize(("degrees", "stays"), [(9.8, True), (10.8, False)])
def test_on_a_slope_an_item_stays_as_steep_as_friction_holds_it(
    cell: Cell, degrees: float, stays: bool
) -> None:
    """A friction of 0.2 is 11.3 degrees, of which one is kept for a tilt of the world."""
    below, above = on_a_slope(cell, degrees, 0.3, 0.05)
    assert of(cell, below, above).stays("above") is stays


@pytest.mark.parametrize(("degrees", "carries"), [(0.0, True), (69.0, True), (71.0, False), (90.0, False)])
def test_a_face_carries_weight_up_to_seventy_degrees_of_slope(
    cell: Cell, degrees: float, carries: bool
) -> None:
    """Beyond that an item seems to hang in the air, and would fall straight down."""
    below, above = on_a_slope(cell, degrees, 0.25, 0.09)
    contacts = of(cell, below, above).touching["above"]
    assert not any(c.b == "above" for c in contacts)
    normals = [c.normal for c in contacts if c.b == "below"]
    np.testing.assert_allclose(normals[0], -below.T_world_item[:3, 2], atol=1e-9)
    assert any(c.normal[2] == -1.0 for c in contacts[1:]) is not carries


@pytest.mark.parametrize("noise", [0.0, 0.002])
def test_solids_touch_up_to_what_settled_items_and_their_noise_leave(cell: Cell, noise: float) -> None:
    for more, touches in ((-0.0001, True), (0.0001, False)):
        gap = 0.0015 + 2 * noise + more
        one = at(cell, "one", shaped(cell, (0.1, 0.1, 0.05)), 0.3, 0.0, 0.025)
        other = at(cell, "other", shaped(cell, (0.1, 0.1, 0.05)), 0.3, 0.1 + gap, 0.025)
        contacts = of(cell, one, other, noise=PoseNoise(noise, 0.0)).touching["one"]
        assert ("other" in {c.b for c in contacts}) is touches


def test_what_hangs_in_the_air_is_carried_by_the_next_thing_under_it(cell: Cell) -> None:
    flat = shaped(cell, (0.1, 0.1, 0.02))
    low, high = at(cell, "low", flat, 0.3, 0.0, 0.01), at(cell, "high", flat, 0.32, 0.0, 0.0301)
    beside = at(cell, "beside", flat, 0.3, 0.11, 0.05)
    hanging = at(cell, "hanging", flat, 0.3, 0.0, 0.08)
    supports = of(cell, low, high, beside, hanging)
    assert supports.carriers("hanging") == ("high",)
    assert supports.lying_on("high") == ("hanging",)
    (contact,) = [c for c in supports.touching["hanging"] if c.b == "high"]
    assert contact.gap == pytest.approx(0.0299) and contact.normal.tolist() == [0.0, 0.0, -1.0]
    elsewhere = replace(high, location="bin_B")
    assert of(cell, low, elsewhere, hanging).carriers("hanging") == ("low",)
    assert "floor" in of(cell, hanging).carriers("hanging")[0]


def test_a_can_rolls_down_a_slope_when_what_is_behind_it_goes(cell: Cell) -> None:
    """On the sloping front of the floor, behind it a box that is taken away."""
    cell_bin, radius = cell.pod.bins[BIN], 0.03
    can = shaped(cell, (radius, 0.05), ShapeKind.CYLINDER)
    x = cell_bin.floor_flat_from - 0.06
    front = np.interp(x, [SLOPE_FROM, cell_bin.floor_flat_from], [cell_bin.floor_front, cell_bin.floor_back])
    slope = np.arctan2(cell_bin.floor_front - cell_bin.floor_back, cell_bin.floor_flat_from - SLOPE_FROM)
    up = pose([x, 0.0, float(front)], rpy=(0.0, float(slope), 0.0))
    lying = pose([0.0, 0.0, radius], rpy=(np.pi / 2, 0.0, 0.0))
    placed = PlacedItem("can", can, BIN, cell.T_world_pod @ cell_bin.T_pod_bin @ up @ lying)
    behind = at(cell, "behind", shaped(cell, (0.1, 0.1, 0.1)), x + radius + 0.0505, 0.0, 0.052)
    supports = of(cell, placed, behind)
    assert "behind" in {c.b for c in supports.touching["can"]}
    assert supports.falling("behind") == ("can",) and supports.rolling("behind") == ()


def test_what_presses_is_counted_where_all_of_its_weight_goes_down(cell: Cell) -> None:
    """A table on one foot: a weight far out on it overturns it, one near the middle does not."""
    foot = at(cell, "foot", shaped(cell, (0.04, 0.04, 0.05), mass=1.0), 0.3, 0.0, 0.025)
    board = at(cell, "board", shaped(cell, (0.2, 0.2, 0.01), mass=0.2), 0.3, 0.0, 0.055)
    for x, mass, stays in (
        (0.01, 0.2, True), (0.03, 0.2, True), (0.05, 0.2, False), (0.05, 0.05, True), (0.015, 5.0, True),
        (0.025, 5.0, False),
    ):  # fmt: skip
        weight = at(cell, "weight", shaped(cell, (0.02, 0.02, 0.02), mass=mass), 0.3 + x, 0.0, 0.07)
        supports = of(cell, foot, board, weight)
        assert supports.carriers("weight") == ("board",)
        assert supports.stays("board") is stays, (x, mass)


def test_the_weight_of_a_whole_pile_counts(cell: Cell) -> None:
    """Two on each other press at the middle of both, weighted by their masses."""
    foot = at(cell, "foot", shaped(cell, (0.04, 0.04, 0.05), mass=1.0), 0.3, 0.0, 0.025)
    board = at(cell, "board", shaped(cell, (0.2, 0.2, 0.01), mass=0.2), 0.3, 0.0, 0.055)
    lower = at(cell, "lower", shaped(cell, (0.06, 0.02, 0.02), mass=0.2), 0.3, 0.0, 0.07)
    for mass, stays in ((0.2, True), (4.0, False)):
        upper = at(cell, "upper", shaped(cell, (0.02, 0.02, 0.02), mass=mass), 0.326, 0.0, 0.09)
        supports = of(cell, foot, board, lower, upper)
        assert supports.carriers("upper") == ("lower",)
        assert supports.stays("board") is stays


@pytest.mark.parametrize("noise", [0.0, 0.002])
def test_near_are_those_whose_gap_may_be_below_the_reach(cell: Cell, noise: float) -> None:
    flat, gap = shaped(cell, (0.1, 0.1, 0.02)), 0.02
    one = at(cell, "one", flat, 0.3, 0.0, 0.05)
    other = at(cell, "other", flat, 0.3, 0.1 + gap, 0.05)
    elsewhere = replace(other, id="elsewhere", location="bin_B")
    supports = of(cell, one, other, elsewhere, noise=PoseNoise(noise, 0.0))
    bound = 2 * noise
    found = {c.b: c for c in supports.near("one", gap - bound + 1e-6)}
    assert "other" in found and "elsewhere" not in found and "one" not in found
    assert found["other"].gap == pytest.approx(gap)
    np.testing.assert_allclose(found["other"].normal, cell.T_world_pod[:3, 1], atol=1e-9)
    assert "other" not in {c.b for c in supports.near("one", gap - bound - 1e-6)}
    assert "elsewhere" in {c.b for c in supports.near("one", 0.0, frozenset({"elsewhere"}))}


def test_near_bodies_of_the_pod_count_as_grown_by_the_error_of_its_pose(cell: Cell) -> None:
    one = at(cell, "one", shaped(cell, (0.1, 0.1, 0.02)), 0.25, 0.0, 0.06)
    exact = Scene(cell, cell.T_world_pod, (one,), EXACT)
    grown = replace(exact, pod_error=Displacement(0.004, 0.003, 0.0))
    (name,) = of(cell, one).carriers("one")
    gap = {c.b: c.gap for c in supports_of(exact).near("one", 0.2)}
    less = {c.b: c.gap for c in supports_of(grown).near("one", 0.2)}
    assert name in gap and set(less) >= set(gap)
    assert all(less[n] <= gap[n] + 1e-9 for n in gap)
    assert max(gap[n] - less[n] for n in gap) == pytest.approx(0.004, abs=1e-3)


def test_of_what_falls_the_highest_goes_first_and_names_decide_between_equals(cell: Cell) -> None:
    base = at(cell, "base", shaped(cell, (0.2, 0.1, 0.05)), 0.3, 0.0, 0.025)
    small = shaped(cell, (0.04, 0.04, 0.04))
    b, a = at(cell, "b", small, 0.25, 0.0, 0.07), at(cell, "a", small, 0.35, 0.0, 0.07)
    top = at(cell, "top", shaped(cell, (0.03, 0.03, 0.02)), 0.25, 0.0, 0.1)
    assert of(cell, base, b, a, top).falling("base") == ("top", "a", "b")


@pytest.mark.parametrize(("degrees", "falls"), [(0.8, False), (1.2, True), (1.8, True)])
def test_a_ball_begins_to_roll_on_a_slope_of_a_degree(cell: Cell, degrees: float, falls: bool) -> None:
    """On a plate that is askew, behind it a box that is taken away."""
    turn, radius = float(np.radians(degrees)), 0.03
    plate = at(cell, "plate", shaped(cell, (0.2, 0.1, 0.02)), 0.3, 0.0, 0.02, (0.0, turn, 0.0))
    T = plate.T_world_item @ pose((0.0, 0.0, 0.01 + radius))
    ball = PlacedItem("ball", shaped(cell, (radius,), ShapeKind.SPHERE), BIN, T)
    behind = PlacedItem(
        "behind", shaped(cell, (0.04, 0.06, 0.06)), BIN, T @ pose((radius + 0.0205, 0.0, 0.0))
    )
    supports = of(cell, plate, ball, behind)
    assert "behind" in {c.b for c in supports.touching["ball"]}
    assert ("ball" in supports.falling("behind")) is falls
    assert ("ball" in supports.rolling("behind")) is not falls
