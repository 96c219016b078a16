"""What a removal does to a pile, by the verifier's own statics: plain cases, and against the planner's."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.shapes import ShapeKind
from pickcli.geometry import pose
from pickcli.scene.scene import TOTE, PlacedItem, PoseNoise, Scene
from pickcli.statics.supports import Supports, supports_of
from pickcli.verification.landing_statics import keeps_standing
from pickcli.verification.pile_statics import Removal, barrier, may_leave, removal
from support.bin_piles import BIN, EXACT, NOISY, at, can_on_a_slope, height, of, on_a_slope, put, shaped

LYING_CAN = (np.pi / 2, 0.0, 0.0)


def scene_of(cell: Cell, *items: PlacedItem, noise: PoseNoise = EXACT) -> Scene:
    return Scene(cell, cell.T_world_pod, items, noise)


def without(gone: str, cell: Cell, *items: PlacedItem, noise: PoseNoise = EXACT) -> Removal:
    return removal(scene_of(cell, *items, noise=noise), gone)


def is_untouched(effects: Removal) -> bool:
    return not (effects.lifted or effects.falling or effects.rolling)


@pytest.mark.parametrize("noise", [EXACT, NOISY])
def test_of_a_stack_all_that_is_above_is_lifted_and_nothing_below(cell: Cell, noise: PoseNoise) -> None:
    z, stack = 0.0, []
    for name in ("kleenex_tissue_box", "i_am_a_bunny_book", "dove_beauty_bar"):
        stack.append(put(cell, name, 0.25, 0.0, z))
        z += height(cell, name)
    bottom = without("kleenex_tissue_box", cell, *stack, noise=noise)
    assert bottom.lifted == bottom.falling == {"i_am_a_bunny_book", "dove_beauty_bar"}
    assert without("i_am_a_bunny_book", cell, *stack, noise=noise).lifted == {"dove_beauty_bar"}
    assert is_untouched(without("dove_beauty_bar", cell, *stack, noise=noise))


@pytest.mark.parametrize(("y", "falls"), [(0.0, False), (0.045, True)])
def test_what_lies_on_two_is_lifted_with_one_and_falls_only_where_the_other_does_not_hold_it(
    cell: Cell, y: float, falls: bool
) -> None:
    box = put(cell, "cherokee_easy_tee_shirt", 0.25, -0.05)
    bar = put(cell, "crayola_24_ct", 0.25, 0.09)
    book = put(cell, "i_am_a_bunny_book", 0.25, y, 0.025, (0, 0, np.pi / 2))
    effects = without(bar.id, cell, box, bar, book)
    assert effects.lifted == {book.id}
    assert effects.falling == ({book.id} if falls else set())


def test_what_leans_falls_and_is_not_lifted_and_what_stands_beside_stays(cell: Cell) -> None:
    box = at(cell, "box", shaped(cell, (0.1, 0.1, 0.14)), 0.3, 0.0, 0.07)
    beside = at(cell, "beside", shaped(cell, (0.05, 0.05, 0.05)), 0.3, 0.0755, 0.025)
    lean, thin, tall = 0.3, 0.014, 0.12
    y, z = (
        s * tall / 2 + c * thin / 2 for s, c in ((np.sin(lean), np.cos(lean)), (np.cos(lean), np.sin(lean)))
    )
    board = shaped(cell, (0.08, thin, tall))
    leaning = at(cell, "leaning", board, 0.3, -(0.05 + y), z, (-lean, 0.0, 0.0))
    effects = without("box", cell, box, beside, leaning)
    assert effects.falling == {"leaning"} and not effects.lifted and not effects.rolling
    assert is_untouched(without("leaning", cell, box, beside, leaning))


def test_a_ball_beside_rolls_if_pushed_on_the_level_and_falls_down_a_slope(cell: Cell) -> None:
    radius = 0.034
    box = put(cell, "kleenex_tissue_box", 0.25, 0.0)
    ball = put(cell, "rawlings_baseball", 0.25, 0.115 / 2 + radius)
    effects = without(box.id, cell, box, ball)
    assert effects.rolling == {ball.id} and not effects.falling and not effects.lifted
    for degrees, falls in ((1.0, False), (2.0, True)):
        turn = float(np.radians(degrees))
        plate = at(cell, "plate", shaped(cell, (0.2, 0.1, 0.02)), 0.3, 0.0, 0.02, (0.0, turn, 0.0))
        T = plate.T_world_item @ pose((0.0, 0.0, 0.01 + radius))
        on_it = PlacedItem("ball", shaped(cell, (radius,), ShapeKind.SPHERE), BIN, T)
        behind = PlacedItem(
            "behind", shaped(cell, (0.04, 0.06, 0.06)), BIN, T @ pose((radius + 0.0205, 0.0, 0.0))
        )
        effects = without("behind", cell, plate, on_it, behind)
        assert ("ball" in effects.falling) is falls and ("ball" in effects.rolling) is not falls


def test_a_roller_that_is_chocked_by_something_else_neither_falls_nor_rolls(cell: Cell) -> None:
    radius, high = 0.03, 0.01
    apart = float(np.sqrt(radius**2 - (radius - high) ** 2))
    strips = [
        at(cell, f"strip{s}", shaped(cell, (0.02, 0.1, high)), 0.3 + s * (0.01 + apart), 0.0, high / 2)
        for s in (-1, 1)
    ]
    can = at(cell, "can", shaped(cell, (radius, 0.1), ShapeKind.CYLINDER), 0.3, 0.0, radius, LYING_CAN)
    end = at(cell, "end", shaped(cell, (0.05, 0.05, 0.12)), 0.3, 0.0755, 0.06)
    assert is_untouched(without("end", cell, can, end, *strips))
    assert without("end", cell, can, end).rolling == {"can"}
    assert without("strip1", cell, can, strips[1]).rolling == {"can"}


@pytest.mark.parametrize(("turn", "stays"), [(0.0, True), (np.pi / 2, False)])
def test_a_can_rolls_down_a_slope_across_its_axis_and_not_along_it(
    cell: Cell, turn: float, stays: bool
) -> None:
    effects = without("beside", cell, *can_on_a_slope(cell, turn))
    assert effects.falling == (set() if stays else {"can"})
    assert effects.rolling == ({"can"} if stays else set())


def test_a_ball_lies_on_the_ground_though_it_is_seen_nearer_to_a_wall(cell: Cell) -> None:
    """Seen 1 mm inside the divider and 1 mm over the floor: nothing near it keeps it up."""
    radius = 0.034
    divider = 0.5 * 0.2988
    ball = at(
        cell, "ball", shaped(cell, (radius,), ShapeKind.SPHERE), 0.3, divider - radius + 0.001, radius + 0.001
    )
    beside = at(cell, "beside", shaped(cell, (0.05, 0.05, 0.08)), 0.3, divider - 2 * radius - 0.027, 0.041)
    assert without("beside", cell, ball, beside, noise=NOISY).falling == set()


def test_two_cans_on_each_other_fall_without_the_box_beside_them(cell: Cell) -> None:
    can = shaped(cell, (0.03, 0.1), ShapeKind.CYLINDER)
    box = at(cell, "box", shaped(cell, (0.05, 0.1, 0.12)), 0.3, 0.0, 0.06)
    cans = [at(cell, name, can, 0.355, 0.0, z, LYING_CAN) for name, z in (("lower", 0.03), ("upper", 0.09))]
    effects = without("box", cell, box, *cans)
    assert effects.falling == {"lower", "upper"} and not effects.lifted and not effects.rolling


@pytest.mark.parametrize(("overhang", "tips"), [(-0.004, False), (0.004, True)])
def test_what_is_kept_in_balance_by_what_is_on_it_falls_without_that(
    cell: Cell, overhang: float, tips: bool
) -> None:
    pier = at(cell, "pier", shaped(cell, (0.1, 0.1, 0.1)), 0.3, 0.0, 0.05)
    plank = at(cell, "plank", shaped(cell, (0.2, 0.1, 0.02)), 0.25 - overhang, 0.0, 0.11)
    block = at(cell, "block", shaped(cell, (0.04, 0.04, 0.02)), 0.3, 0.0, 0.13)
    effects = without("block", cell, pier, plank, block)
    assert effects.falling == ({"plank"} if tips else set()) and effects.lifted == set()


def test_what_hangs_in_the_air_is_carried_by_what_is_next_below(cell: Cell) -> None:
    flat = shaped(cell, (0.1, 0.1, 0.02))
    low, high = at(cell, "low", flat, 0.3, 0.0, 0.01), at(cell, "high", flat, 0.32, 0.0, 0.0301)
    beside = at(cell, "beside", flat, 0.3, 0.11, 0.05)
    hanging = at(cell, "hanging", flat, 0.3, 0.0, 0.08)
    assert without("high", cell, low, high, beside, hanging).lifted == {"hanging"}
    assert is_untouched(without("low", cell, low, hanging, beside)) is False
    assert is_untouched(without("beside", cell, low, high, beside, hanging))


@pytest.mark.parametrize(("x", "is_over"), [(0.25, False), (0.25 - 2.0**-20, True)])
def test_what_hangs_exactly_beside_an_item_does_not_hang_over_it(cell: Cell, x: float, is_over: bool) -> None:
    """Sizes and places are sums of powers of two: no rounding moves them."""
    cube = shaped(cell, (0.25, 0.25, 0.25))
    for way in ((x, 0.0), (0.0, x), (-x, 0.0), (0.0, -x)):
        low = PlacedItem("low", cube, BIN, pose((-2.0, 0.0, 4.0)))
        high = PlacedItem("high", cube, BIN, pose((-2.0 + way[0], way[1], 4.5)))
        assert (without("low", cell, low, high).lifted == {"high"}) is is_over


def test_only_what_is_in_the_same_place_is_asked(cell: Cell) -> None:
    box = put(cell, "kleenex_tissue_box", 0.25, 0.0)
    book = put(cell, "i_am_a_bunny_book", 0.25, 0.0, height(cell, box.id))
    elsewhere = PlacedItem(book.id, book.item, "bin_B", book.T_world_item)
    assert without(box.id, cell, box, book).lifted == {book.id}
    assert is_untouched(without(box.id, cell, box, elsewhere))


@pytest.mark.parametrize(("gap", "touches"), [(0.0014, True), (0.0016, False)])
def test_solids_touch_up_to_what_settled_items_and_their_noise_leave(
    cell: Cell, gap: float, touches: bool
) -> None:
    box = put(cell, "kleenex_tissue_box", 0.25, 0.0)
    radius = 0.034
    for noise in (0.0, 0.002):
        ball = put(cell, "rawlings_baseball", 0.25, 0.115 / 2 + radius + gap + 2 * noise)
        effects = without(box.id, cell, box, ball, noise=PoseNoise(noise, 0.0))
        assert (effects.rolling == {ball.id}) is touches


@pytest.mark.parametrize(("out", "stands"), [(0.048, True), (0.052, False)])
def test_an_item_stands_where_its_centre_is_over_what_carries_it(
    cell: Cell, out: float, stands: bool
) -> None:
    pier = at(cell, "pier", shaped(cell, (0.1, 0.1, 0.1)), 0.3, 0.0, 0.05)
    block = at(cell, "block", shaped(cell, (0.1, 0.06, 0.04)), 0.3 + out, 0.0, 0.125)
    assert keeps_standing(scene_of(cell, pier, block), "block") is stands


def test_what_can_roll_stands_on_the_level_only(cell: Cell) -> None:
    can = shaped(cell, (0.03, 0.1), ShapeKind.CYLINDER)
    lying = at(cell, "can", can, 0.3, 0.0, 0.03, LYING_CAN)
    assert keeps_standing(scene_of(cell, lying), "can")
    below, _ = on_a_slope(cell, 5.0, 0.3, 0.08)
    T = below.T_world_item @ pose((0.0, 0.0, 0.025 + 0.03), rpy=LYING_CAN)
    assert not keeps_standing(scene_of(cell, below, PlacedItem("can", can, BIN, T)), "can")
    upright = PlacedItem("can", can, BIN, below.T_world_item @ pose((0.0, 0.0, 0.025 + 0.05)))
    assert keeps_standing(scene_of(cell, below, upright), "can")


@given(st.integers(0, 10**6), st.sampled_from((EXACT, NOISY)))
@settings(max_examples=40, deadline=None, derandomize=True)
def test_the_planner_clears_first_whatever_the_verifier_would_refuse(seed: int, noise: PoseNoise) -> None:
    """Boxes and cans on each other and beside each other, none of which the planner thinks unsteady."""
    scene, supports = steady_pile(seed, noise)
    for placed in scene.items:
        effects, cleared = removal(scene, placed.id), set(supports.falling(placed.id))
        assert effects.lifted | effects.falling <= cleared
        assert effects.rolling <= set(supports.rolling(placed.id)) | cleared


def steady_pile(seed: int, noise: PoseNoise) -> tuple[Scene, Supports]:
    """The first pile from a seed on in which everything stays, and who needs whom in it."""
    cell, rng = load_cell("apc2016_delft"), np.random.default_rng(seed)
    while True:
        supports = of(cell, *drawn_pile(cell, rng), noise=noise)
        balance = supports.balance
        if all(balance.stays(name) or balance.lies_level(name) for name in supports.graph.items):
            return supports.graph.scene, supports


def drawn_pile(cell: Cell, rng: np.random.Generator) -> list[PlacedItem]:
    """Two columns of one to three items that meet each other, each over the middle part of the one below."""
    found: list[PlacedItem] = []
    for side in (-1.0, 1.0):
        x, y, z, room = 0.3, 0.0, 0.0, 1.0
        for _ in range(int(rng.integers(1, 4))):
            a, b, c = (float(v) for v in rng.uniform(0.02, 0.1, 3))
            x, y = x + room * float(rng.uniform(-0.03, 0.03)), y + float(rng.uniform(-0.02, 0.02)) * (z > 0.0)
            y = side * b / 2 if z == 0.0 else y
            name, mass = f"item{len(found)}", float(rng.uniform(0.05, 1.0))
            if rng.random() < 0.3:
                can = shaped(cell, (b / 2, a), ShapeKind.CYLINDER, mass)
                found.append(at(cell, name, can, x, y, z + b / 2, (0.0, np.pi / 2, 0.0)))
                z += b
            else:
                found.append(at(cell, name, shaped(cell, (a, b, c), mass=mass), x, y, z + c / 2))
                z += c
            room = a
    return found


def test_piles_that_are_drawn_fall_often_enough_to_judge_anything(cell: Cell) -> None:
    found = [drawn_pile(cell, np.random.default_rng(seed)) for seed in range(20)]
    effects = [removal(scene_of(cell, *items), items[0].id) for items in found]
    assert sum(bool(each.lifted) for each in effects) >= 5
    assert sum(bool(each.falling - each.lifted) for each in effects) >= 1
    assert sum(bool(each.rolling) for each in effects) >= 1


@settings(max_examples=60, deadline=None)
@given(over=st.floats(-0.03, 0.06), turn=st.tuples(*[st.floats(-3.0, 3.0)] * 3), noise=st.floats(0.0, 0.004))
def test_planner_and_verifier_agree_about_what_may_get_over_a_rim(
    cell: Cell, over: float, turn: tuple[float, float, float], noise: float
) -> None:
    tote = cell.places[TOTE]
    T_mouth = scene_of(cell).T_world_place(tote) @ tote.access.T_place_mouth
    rim = float(T_mouth[2, 3])
    for name in ("dove_beauty_bar", "scotch_bubble_mailer", "up_glucose_bottle", "rawlings_baseball"):
        T = pose((T_mouth[0, 3], T_mouth[1, 3], rim + over), rpy=turn)
        placed = PlacedItem(name, cell.item(name), TOTE, T)
        scene = scene_of(cell, placed, noise=PoseNoise(noise, 0.01))
        thickness = min(placed.item.shape.extents)
        assert barrier(scene, tote, placed) == pytest.approx(rim + thickness / 2)
        leaves = supports_of(scene).may_leave_over(rim, name)
        assert may_leave(scene, tote, placed) == leaves
        assert leaves or over + noise < thickness / 2
