"""What rests on what, and what falls or rolls without it: cases whose answer is plain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import Displacement
from pickcli.cell.shapes import ShapeKind
from pickcli.geometry import pose
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.statics.supports import supports_of
from support.bin_piles import (
    BIN,
    EXACT,
    NOISY,
    at,
    can_on_a_slope,
    height,
    in_a_slot,
    of,
    on_a_slope,
    put,
    shaped,
)


@pytest.mark.parametrize("noise", [EXACT, NOISY])
def test_what_lies_on_another_falls_without_it_and_not_the_other_way(cell: Cell, noise: PoseNoise) -> None:
    box = put(cell, "kleenex_tissue_box", 0.25, 0.0)
    book = put(cell, "i_am_a_bunny_book", 0.25, 0.0, height(cell, box.id))
    supports = of(cell, box, book, noise=noise)
    assert supports.graph.carriers(book.id) == (box.id,)
    assert supports.graph.lying_on(box.id) == (book.id,)
    assert supports.falling(box.id) == (book.id,)
    assert supports.falling(book.id) == ()
    assert supports.balance.stays(box.id, {book.id}) and not supports.balance.stays(book.id, {box.id})


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
    assert set(supports.graph.carriers(book.id)) == {box.id, bar.id}
    assert supports.balance.stays(book.id, {bar.id}) is stays
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
    assert {c.b for c in supports.graph.touching[box.id]} >= {beside.id, leaning.id}
    assert supports.falling(box.id) == (leaning.id,)
    assert supports.rolling(box.id) == ()


def test_a_ball_beside_rolls_down_a_slope_and_stays_on_the_level(cell: Cell) -> None:
    radius = 0.034
    box = put(cell, "kleenex_tissue_box", 0.25, 0.0)
    level = put(cell, "rawlings_baseball", 0.25, 0.115 / 2 + radius)
    supports = of(cell, box, level)
    assert supports.falling(box.id) == () and supports.rolling(box.id) == (level.id,)
    cell_bin = cell.pod.bins[BIN]
    x = cell_bin.room.floor_flat_from - 0.05
    front = float(cell_bin.room.floor_at(x))
    slope = np.arctan2(
        cell_bin.room.floor_front - cell_bin.room.floor_back,
        cell_bin.room.floor_flat_from - cell_bin.room.slope_from,
    )
    at = pose([x, 0.0, front + radius / np.cos(slope)])
    ball = replace(level, T_world_item=cell.T_world_place(cell_bin) @ at)
    behind = put(cell, "kleenex_tissue_box", x + radius + 0.0655, 0.0)
    supports = of(cell, ball, behind)
    assert supports.falling(behind.id) == (ball.id,)
    assert supports.rolling(behind.id) == ()
    assert supports.falling(ball.id) == ()


def test_what_seems_to_hang_in_the_air_lies_on_what_is_below(cell: Cell) -> None:
    box = put(cell, "kleenex_tissue_box", 0.25, 0.0)
    book = put(cell, "i_am_a_bunny_book", 0.25, 0.0, height(cell, box.id) + 0.03)
    supports = of(cell, box, book)
    assert supports.graph.carriers(book.id) == (box.id,)
    assert supports.falling(box.id) == (book.id,)


def test_a_board_is_between_items_of_two_bins(cell: Cell) -> None:
    box = put(cell, "kleenex_tissue_box", 0.25, 0.0)
    other = replace(put(cell, "i_am_a_bunny_book", 0.25, 0.0, height(cell, box.id)), location="bin_B")
    assert of(cell, box, other).falling(box.id) == ()


def test_noise_makes_neighbours_that_may_touch(cell: Cell) -> None:
    box = put(cell, "kleenex_tissue_box", 0.25, 0.0)
    beside = put(cell, "dove_beauty_bar", 0.25, 0.115 / 2 + 0.033 + 0.004)
    assert beside.id not in {c.b for c in of(cell, box, beside).graph.touching[box.id]}
    assert beside.id in {c.b for c in of(cell, box, beside, noise=NOISY).graph.touching[box.id]}


def test_every_contact_is_seen_from_both_sides(cell: Cell) -> None:
    box = put(cell, "kleenex_tissue_box", 0.25, 0.0)
    book = put(cell, "i_am_a_bunny_book", 0.26, 0.01, height(cell, box.id))
    touching = of(cell, box, book).graph.touching
    (one,) = [c for c in touching[box.id] if c.b == book.id]
    (other,) = [c for c in touching[book.id] if c.b == box.id]
    assert one.gap == other.gap
    np.testing.assert_array_equal(one.normal, -other.normal)


@pytest.mark.parametrize(("degrees", "carries"), [(0.0, True), (69.0, True), (71.0, False), (90.0, False)])
def test_a_face_carries_weight_up_to_seventy_degrees_of_slope(
    cell: Cell, degrees: float, carries: bool
) -> None:
    """Beyond that an item seems to hang in the air, and would fall straight down."""
    below, above = on_a_slope(cell, degrees, 0.25, 0.09)
    contacts = of(cell, below, above).graph.touching["above"]
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
        contacts = of(cell, one, other, noise=PoseNoise(noise, 0.0)).graph.touching["one"]
        assert ("other" in {c.b for c in contacts}) is touches


def test_what_hangs_in_the_air_is_carried_by_the_next_thing_under_it(cell: Cell) -> None:
    flat = shaped(cell, (0.1, 0.1, 0.02))
    low, high = at(cell, "low", flat, 0.3, 0.0, 0.01), at(cell, "high", flat, 0.32, 0.0, 0.0301)
    beside = at(cell, "beside", flat, 0.3, 0.11, 0.05)
    hanging = at(cell, "hanging", flat, 0.3, 0.0, 0.08)
    supports = of(cell, low, high, beside, hanging)
    assert supports.graph.carriers("hanging") == ("high",)
    assert supports.graph.lying_on("high") == ("hanging",)
    (contact,) = [c for c in supports.graph.touching["hanging"] if c.b == "high"]
    assert contact.gap == pytest.approx(0.0299) and contact.normal.tolist() == [0.0, 0.0, -1.0]
    elsewhere = replace(high, location="bin_B")
    assert of(cell, low, elsewhere, hanging).graph.carriers("hanging") == ("low",)
    assert "floor" in of(cell, hanging).graph.carriers("hanging")[0]


def test_a_can_rolls_down_a_slope_when_what_is_behind_it_goes(cell: Cell) -> None:
    """On the sloping front of the floor, behind it a box that is taken away."""
    cell_bin, radius = cell.pod.bins[BIN], 0.03
    can = shaped(cell, (radius, 0.05), ShapeKind.CYLINDER)
    x = cell_bin.room.floor_flat_from - 0.06
    front = float(cell_bin.room.floor_at(x))
    slope = np.arctan2(
        cell_bin.room.floor_front - cell_bin.room.floor_back,
        cell_bin.room.floor_flat_from - cell_bin.room.slope_from,
    )
    up = pose([x, 0.0, float(front)], rpy=(0.0, float(slope), 0.0))
    lying = pose([0.0, 0.0, radius], rpy=(np.pi / 2, 0.0, 0.0))
    placed = PlacedItem("can", can, BIN, cell.T_world_place(cell_bin) @ up @ lying)
    behind = at(cell, "behind", shaped(cell, (0.1, 0.1, 0.1)), x + radius + 0.0505, 0.0, 0.052)
    supports = of(cell, placed, behind)
    assert "behind" in {c.b for c in supports.graph.touching["can"]}
    assert supports.falling("behind") == ("can",) and supports.rolling("behind") == ()


@pytest.mark.parametrize("noise", [0.0, 0.002])
def test_near_are_those_whose_gap_may_be_below_the_reach(cell: Cell, noise: float) -> None:
    flat, gap = shaped(cell, (0.1, 0.1, 0.02)), 0.02
    one = at(cell, "one", flat, 0.3, 0.0, 0.05)
    other = at(cell, "other", flat, 0.3, 0.1 + gap, 0.05)
    elsewhere = replace(other, id="elsewhere", location="bin_B")
    supports = of(cell, one, other, elsewhere, noise=PoseNoise(noise, 0.0))
    bound = 2 * noise
    found = {c.b: c for c in supports.graph.near("one", gap - bound + 1e-6)}
    assert "other" in found and "elsewhere" not in found and "one" not in found
    assert found["other"].gap == pytest.approx(gap)
    np.testing.assert_allclose(found["other"].normal, cell.T_world_pod[:3, 1], atol=1e-9)
    assert "other" not in {c.b for c in supports.graph.near("one", gap - bound - 1e-6)}
    assert "elsewhere" in {c.b for c in supports.graph.near("one", 0.0, frozenset({"elsewhere"}))}


def test_near_bodies_of_the_pod_count_as_grown_by_the_error_of_its_pose(cell: Cell) -> None:
    one = at(cell, "one", shaped(cell, (0.1, 0.1, 0.02)), 0.25, 0.0, 0.06)
    exact = Scene(cell, cell.T_world_pod, (one,), EXACT)
    grown = replace(exact, pod_error=Displacement(0.004, 0.003, 0.0))
    (name,) = of(cell, one).graph.carriers("one")
    gap = {c.b: c.gap for c in supports_of(exact).graph.near("one", 0.2)}
    less = {c.b: c.gap for c in supports_of(grown).graph.near("one", 0.2)}
    assert name in gap and set(less) >= set(gap)
    assert all(less[n] <= gap[n] + 1e-9 for n in gap)
    assert max(gap[n] - less[n] for n in gap) == pytest.approx(0.004, abs=1e-3)


def test_of_what_falls_the_highest_goes_first_and_names_decide_between_equals(cell: Cell) -> None:
    base = at(cell, "base", shaped(cell, (0.2, 0.1, 0.05)), 0.3, 0.0, 0.025)
    small = shaped(cell, (0.04, 0.04, 0.04))
    b, a = at(cell, "b", small, 0.25, 0.0, 0.07), at(cell, "a", small, 0.35, 0.0, 0.07)
    top = at(cell, "top", shaped(cell, (0.03, 0.03, 0.02)), 0.25, 0.0, 0.1)
    assert of(cell, base, b, a, top).falling("base") == ("top", "a", "b")
    tall = at(cell, "tall", shaped(cell, (0.04, 0.04, 0.1)), 0.35, 0.0, 0.1)
    assert of(cell, base, b, tall, top).falling("base") == ("top", "b", "tall")


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
    assert "behind" in {c.b for c in supports.graph.touching["ball"]}
    assert ("ball" in supports.falling("behind")) is falls
    assert ("ball" in supports.rolling("behind")) is not falls


def test_what_can_roll_and_is_chocked_does_not_roll(cell: Cell) -> None:
    """When what it touches at its end goes: it lies in a slot, or on level ground between two strips."""
    end = at(cell, "end", shaped(cell, (0.05, 0.05, 0.12)), 0.3, 0.0755, 0.06)
    assert in_a_slot(cell, 20.0, end).rolling("end") == ()
    radius, high = 0.03, 0.01
    apart = float(np.sqrt(radius**2 - (radius - high) ** 2))
    strip = shaped(cell, (0.02, 0.1, high))
    strips = [at(cell, f"strip{s}", strip, 0.3 + s * (0.01 + apart), 0.0, high / 2) for s in (-1, 1)]
    can = shaped(cell, (radius, 0.1), ShapeKind.CYLINDER)
    lying = at(cell, "can", can, 0.3, 0.0, radius, (np.pi / 2, 0.0, 0.0))
    assert of(cell, lying, end, *strips).rolling("end") == ()
    supports = of(cell, lying, end)
    assert supports.rolling("end") == ("can",) and supports.balance.lies_level("can")
    assert not of(cell, lying, strips[0]).balance.lies_level("can")  # it lies on an edge, too


def test_what_has_lost_all_that_carried_it_falls(cell: Cell) -> None:
    """Two cans on each other beside a box: without the box the lower one rolls, and then the upper one."""
    can, turn = shaped(cell, (0.03, 0.1), ShapeKind.CYLINDER), (np.pi / 2, 0.0, 0.0)
    box = at(cell, "box", shaped(cell, (0.05, 0.1, 0.12)), 0.3, 0.0, 0.06)
    cans = [at(cell, name, can, 0.355, 0.0, z, turn) for name, z in (("lower", 0.03), ("upper", 0.09))]
    assert of(cell, box, *cans).falling("box") == ("upper", "lower")


def test_what_is_unsteady_and_cannot_roll_falls_on_level_ground_too(cell: Cell) -> None:
    board = at(cell, "board", shaped(cell, (0.002, 0.1, 0.16)), 0.3, 0.0, 0.08)
    box = at(cell, "box", shaped(cell, (0.1, 0.1, 0.1)), 0.3515, 0.0, 0.05)
    supports = of(cell, board, box)
    assert not supports.balance.lies_level("board")
    assert supports.falling("box") == ("board",) and supports.rolling("box") == ()


@pytest.mark.parametrize(("turn", "stays"), [(0.0, True), (np.pi / 2, False)])
def test_a_can_rolls_down_a_slope_across_its_axis_and_not_along_it(
    cell: Cell, turn: float, stays: bool
) -> None:
    supports = of(cell, *can_on_a_slope(cell, turn))
    assert (supports.falling("beside") == ()) is stays
    assert (supports.rolling("beside") == ("can",)) is stays


def test_what_carries_something_does_not_lie_as_something_that_stays(cell: Cell) -> None:
    """A can with a weight on top: pushed or not, the two do not stay like this."""
    radius = 0.03
    can = at(
        cell, "can", shaped(cell, (radius, 0.1), ShapeKind.CYLINDER), 0.3, 0.0, radius, (np.pi / 2, 0.0, 0.0)
    )
    weight = at(cell, "weight", shaped(cell, (0.04, 0.04, 0.02)), 0.3, 0.0, 2 * radius + 0.01)
    assert of(cell, can).balance.lies_level("can")
    assert not of(cell, can, weight).balance.lies_level("can")


@pytest.mark.parametrize("noise", [0.0, 0.002])
def test_near_is_as_far_as_two_rods_reach(cell: Cell, noise: float) -> None:
    """End to end, so that their middles are as far from each other as they can be."""
    rod, gap = shaped(cell, (0.01, 0.12, 0.01)), 0.02
    one, other = at(cell, "one", rod, 0.3, -0.07, 0.05), at(cell, "other", rod, 0.3, 0.05 + gap, 0.05)
    supports = of(cell, one, other, noise=PoseNoise(noise, 0.0))
    for more, is_near in ((1e-6, True), (-1e-6, False)):
        assert ("other" in {c.b for c in supports.graph.near("one", gap - 2 * noise + more)}) is is_near


def test_near_are_gaps_below_the_reach_and_not_those_that_equal_it(cell: Cell) -> None:
    flat = shaped(cell, (0.1, 0.1, 0.02))
    supports = of(cell, at(cell, "one", flat, 0.3, 0.0, 0.05), at(cell, "other", flat, 0.3, 0.12, 0.05))
    (gap,) = [c.gap for c in supports.graph.near("one", 0.1) if c.b == "other"]
    for reach, is_near in ((gap, False), (np.nextafter(gap, 1.0), True)):
        assert ("other" in {c.b for c in supports.graph.near("one", float(reach))}) is is_near


def test_what_hangs_exactly_beside_an_item_does_not_hang_over_it(cell: Cell) -> None:
    """Sizes and places are sums of powers of two: no rounding moves them."""
    cube = shaped(cell, (0.25, 0.25, 0.25))
    for x, is_over in ((0.25, False), (0.25 - 2.0**-20, True)):
        poses = {"low": pose((-2.0, 0.0, 4.0)), "high": pose((-2.0 + x, 0.0, 4.5))}
        supports = of(cell, *(PlacedItem(name, cube, BIN, T) for name, T in poses.items()))
        assert ("low" in supports.graph.carriers("high")) is is_over


@pytest.mark.parametrize(("degrees", "falls"), [(20.0, ()), (40.0, ("plate", "roll"))])
def test_what_lies_where_no_friction_holds_is_held_by_what_is_on_it(
    cell: Cell, degrees: float, falls: tuple[str, ...]
) -> None:
    """A plate on the flank of a roll, and a block on it that must lean on something, or both would slide."""
    radius, thick, side = 0.07, 0.03, 0.05
    turn = float(np.radians(degrees))
    roll = at(
        cell,
        "roll",
        shaped(cell, (radius, 0.28), ShapeKind.CYLINDER),
        0.3,
        0.0,
        radius,
        (0.0, np.pi / 2, 0.0),
    )
    plate, block = (
        at(
            cell,
            name,
            shaped(cell, size),
            0.3,
            -out * np.sin(turn),
            radius + out * np.cos(turn),
            (turn, 0.0, 0.0),
        )
        for name, size, out in (
            ("plate", (0.12, 0.12, thick), radius + thick / 2),
            ("block", (side, side, side), radius + thick + side / 2),
        )
    )
    supports = of(cell, roll, plate, block)
    assert supports.graph.carriers("block") == ("plate",) and not supports.balance.stays("plate")
    assert supports.falling("block") == falls


@pytest.mark.parametrize("degrees", [25.0, 40.0, 50.0])
def test_what_leans_on_a_roll_on_level_ground_is_taken_off_it_without_it(cell: Cell, degrees: float) -> None:
    """The roll bears it from aside, and rolls only if it is pushed: neither holds the other."""
    radius, thick = 0.07, 0.02
    turn, out = float(np.radians(degrees)), radius + thick / 2
    roll_shape = shaped(cell, (radius, 0.28), ShapeKind.CYLINDER)
    roll = at(cell, "roll", roll_shape, 0.3, 0.0, radius, (0.0, np.pi / 2, 0.0))
    y, z = -out * np.sin(turn), radius + out * np.cos(turn)
    plate = at(cell, "plate", shaped(cell, (0.12, 0.12, thick)), 0.3, y, z, (turn, 0.0, 0.0))
    supports = of(cell, roll, plate)
    assert supports.graph.carriers("plate") == ("roll",)
    assert supports.falling("plate") == () and supports.rolling("plate") == ("roll",)
    assert supports.falling("roll") == ("plate",)


@pytest.mark.parametrize(("overhang", "tips"), [(-0.004, False), (0.004, True)])
@pytest.mark.parametrize("levels", [1, 2])
def test_what_is_kept_in_balance_by_what_is_on_it_falls_without_that(
    cell: Cell, overhang: float, tips: bool, levels: int
) -> None:
    """A plank with its middle past the edge of a pier, and blocks on its inner end, one on the other."""
    pier = at(cell, "pier", shaped(cell, (0.1, 0.1, 0.1)), 0.3, 0.0, 0.05)
    plank = at(cell, "plank", shaped(cell, (0.2, 0.1, 0.02)), 0.25 - overhang, 0.0, 0.11)
    block = shaped(cell, (0.04, 0.04, 0.02))
    blocks = [at(cell, f"block{k}", block, 0.3, 0.0, 0.13 + 0.02 * k) for k in range(levels)]
    supports = of(cell, pier, plank, *blocks)
    assert supports.falling(blocks[-1].id) == (("plank",) if tips and levels == 1 else ())
    assert supports.falling("block0")[levels - 1 :] == (("plank",) if tips else ())


@pytest.mark.parametrize(("inside", "tips"), [(0.011, True), (0.009, False)])
def test_a_counterweight_holds_by_its_lever(cell: Cell, inside: float, tips: bool) -> None:
    """Half as heavy as the plank it must be twice as far from the edge; else something else held that."""
    pier = at(cell, "pier", shaped(cell, (0.1, 0.1, 0.1)), 0.3, 0.0, 0.05)
    plank = at(cell, "plank", shaped(cell, (0.2, 0.1, 0.02)), 0.245, 0.0, 0.11)
    light = replace(shaped(cell, (0.01, 0.04, 0.02)), mass=plank.item.mass / 2)
    weight = at(cell, "weight", light, 0.25 + inside, 0.0, 0.13)
    supports = of(cell, pier, plank, weight)
    assert supports.falling("weight") == (("plank",) if tips else ())


@pytest.mark.parametrize("noise", [EXACT, NOISY])
@pytest.mark.parametrize(("overhang", "tips"), [(-0.012, False), (0.012, True)])
def test_what_lies_beside_its_support_as_it_is_seen_may_be_held_by_what_is_on_it(
    cell: Cell, overhang: float, tips: bool, noise: PoseNoise
) -> None:
    """A book across the outer end of a plank and a tower: its middle is beside the pier too."""
    pier = at(cell, "pier", shaped(cell, (0.1, 0.1, 0.1)), 0.3, 0.0, 0.05)
    plank = at(cell, "plank", shaped(cell, (0.2, 0.1, 0.02)), 0.25 - overhang, 0.0, 0.11)
    tower = at(cell, "tower", shaped(cell, (0.06, 0.04, 0.12)), 0.24, -0.1, 0.06)
    book = at(cell, "book", shaped(cell, (0.16, 0.15, 0.004)), 0.24, -0.05, 0.122)
    supports = of(cell, pier, plank, tower, book, noise=noise)
    assert supports.falling("book") == (("plank",) if tips else ())


@pytest.mark.parametrize(("degrees", "falls"), [(1.9, False), (3.2, True)])
def test_a_plate_over_an_edge_stays_without_its_weight_if_errors_explain_the_gap(
    cell: Cell, degrees: float, falls: bool
) -> None:
    """Faces that are turned by more than errors of poses explain meet at an edge, and it settles."""
    box = at(cell, "box", shaped(cell, (0.2, 0.2, 0.1), mass=0.4), 0.3, 0.0, 0.05)
    edge = box.T_world_item @ pose((0.1, 0.0, 0.05), rpy=(0.0, float(np.radians(degrees)), 0.0))
    plate = shaped(cell, (0.25, 0.14, 0.02), mass=0.02)
    weight = shaped(cell, (0.02, 0.14, 0.04), mass=0.5)
    plate_on_it = PlacedItem("plate", plate, BIN, edge @ pose((-0.09, 0.0, 0.01)))
    weight_on_it = PlacedItem("weight", weight, BIN, edge @ pose((0.025, 0.0, 0.04)))
    assert ("plate" in of(cell, box, plate_on_it, weight_on_it, noise=NOISY).falling("weight")) is falls


def test_on_what_is_narrow_either_weight_of_a_see_saw_keeps_the_other(cell: Cell) -> None:
    """A board across a roll; one of the two is held by a tower too, and presses with what it takes."""
    roll = at(cell, "roll", shaped(cell, (0.07, 0.28), ShapeKind.CYLINDER), 0.3, 0.0, 0.07, (0, np.pi / 2, 0))
    board = at(cell, "board", shaped(cell, (0.1, 0.2, 0.02)), 0.3, 0.0, 0.15)
    block = at(cell, "block", shaped(cell, (0.04, 0.04, 0.04), mass=0.1), 0.3, -0.06, 0.18)
    tower = at(cell, "tower", shaped(cell, (0.06, 0.04, 0.16)), 0.3, 0.13, 0.08)
    bridge = at(cell, "bridge", shaped(cell, (0.05, 0.12, 0.02)), 0.3, 0.1, 0.17)
    supports = of(cell, roll, board, block, tower, bridge)
    assert {"board", "block"} <= set(supports.falling("bridge"))
    assert "board" not in of(cell, roll, board, tower, block).falling("tower")


def test_what_may_stand_beside_what_is_narrow_stands_on_it(cell: Cell) -> None:
    rail = at(cell, "rail", shaped(cell, (0.3, 0.01, 0.05)), 0.3, 0.0, 0.025)
    plank = at(cell, "plank", shaped(cell, (0.2, 0.012, 0.08)), 0.3, 0.002, 0.09)
    exact, noisy = (of(cell, rail, plank, noise=noise).balance.footing("plank") for noise in (EXACT, NOISY))
    assert np.ptp(exact[:, 1]) == pytest.approx(0.009, abs=1e-6)
    assert noisy == pytest.approx(exact)


def test_the_footing_is_as_much_smaller_as_both_poses_may_be_off(cell: Cell) -> None:
    """A plank across a block, each of which may be 2 mm off: 4 mm less on either side of the block."""
    block = at(cell, "block", shaped(cell, (0.1, 0.1, 0.05)), 0.3, 0.0, 0.025)
    plank = at(cell, "plank", shaped(cell, (0.2, 0.06, 0.02)), 0.3, 0.0, 0.06)
    found = of(cell, block, plank, noise=PoseNoise(0.002, 0.0)).balance.footing("plank")
    local = (found - plank.T_world_item[:3, 3]) @ plank.T_world_item[:3, :3]
    np.testing.assert_allclose(np.ptp(local, axis=0), (0.092, 0.06, 0.0), atol=1e-6)


def test_what_is_over_nothing_has_no_footing(cell: Cell) -> None:
    beyond = at(cell, "beyond", shaped(cell, (0.1, 0.1, 0.05)), 9.0, 0.0, 0.025)
    supports = of(cell, beyond)
    assert supports.graph.carriers("beyond") == () and supports.balance.footing("beyond").shape == (0, 3)


def test_what_is_as_high_carries_nothing(cell: Cell) -> None:
    """Two thin boards in one place, over nothing."""
    board = shaped(cell, (0.02, 0.1, 0.1))
    one, other = (at(cell, name, board, 9.0, 0.0, 0.5) for name in ("one", "other"))
    supports = of(cell, one, other)
    assert [c.b for c in supports.graph.touching["one"]] == ["other"]
    assert supports.graph.carriers("one") == supports.graph.carriers("other") == ()


def test_what_keeps_no_balance_under_an_item_that_is_taken_does_not_roll(cell: Cell) -> None:
    """A box on its edge, with and without the one on it: only what can roll does."""
    below, above = on_a_slope(cell, 12.0, 0.3, 0.05)
    supports = of(cell, below, above)
    assert not supports.balance.stays("below") and not supports.balance.stays("below", {"above"})
    assert supports.rolling("above") == supports.falling("above") == ()
