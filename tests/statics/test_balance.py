"""Whether an item keeps its balance: cases on both sides of where it is lost."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.geometry import pose
from pickcli.scene.scene import TOTE, PlacedItem, PoseNoise
from support.bin_piles import EXACT, NOISY, at, in_a_slot, of, on_a_slope, shaped


@pytest.mark.parametrize("angle", [0.0, 1.0])
@pytest.mark.parametrize("yaw", [0.0, np.pi / 2, np.pi / 4])
def test_a_board_on_its_edge_stands_if_no_tilt_of_the_world_throws_it_over(
    cell: Cell, angle: float, yaw: float
) -> None:
    """One degree, and what its pose may be off: its middle 80 mm high must stay over its foot."""
    noise, least = PoseNoise(0.0, float(np.radians(angle))), 0.16 * np.tan(np.radians(1.0 + angle))
    for width, stands in ((least + 0.00001, True), (least - 0.00001, False)):
        board = at(cell, "board", shaped(cell, (width, 0.1, 0.16)), 0.3, 0.0, 0.08, (0.0, 0.0, yaw))
        assert of(cell, board, noise=noise).balance.stays("board") is stands


@pytest.mark.parametrize("direction", [(1, 0), (-1, 0), (0, 1), (0, -1)])
def test_what_overhangs_stays_while_its_middle_is_over_what_carries_it(
    cell: Cell, direction: tuple[int, int]
) -> None:
    """And over it still when the world is tilted by a degree: 30 mm high, that is half a millimetre."""
    below = at(cell, "below", shaped(cell, (0.1, 0.1, 0.05)), 0.3, 0.0, 0.025)
    least = 0.03 * np.tan(np.radians(1.0))
    for short, stays in ((least + 0.00001, True), (least - 0.00001, False)):
        x, y = ((0.05 - short) * d for d in direction)
        above = at(cell, "above", shaped(cell, (0.06, 0.06, 0.06)), 0.3 + x, y, 0.08)
        supports = of(cell, below, above)
        assert supports.graph.carriers("above") == ("below",)
        assert supports.balance.stays("above") is stays


def test_what_carries_an_item_counts_as_smaller_by_what_both_poses_may_be_off(cell: Cell) -> None:
    below = at(cell, "below", shaped(cell, (0.1, 0.1, 0.05)), 0.3, 0.0, 0.025)
    for short, stays in ((0.0048, True), (0.0042, False)):
        above = at(cell, "above", shaped(cell, (0.06, 0.06, 0.06)), 0.35 - short, 0.0, 0.08)
        assert of(cell, below, above, noise=PoseNoise(0.002, 0.0)).balance.stays("above") is stays


@pytest.mark.parametrize(("degrees", "stays"), [(9.8, True), (10.8, False)])
def test_on_a_slope_an_item_stays_as_steep_as_friction_holds_it(
    cell: Cell, degrees: float, stays: bool
) -> None:
    """A friction of 0.2 is 11.3 degrees, of which one is kept for a tilt of the world."""
    below, above = on_a_slope(cell, degrees, 0.3, 0.05)
    assert of(cell, below, above).balance.stays("above") is stays


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
        assert supports.graph.carriers("weight") == ("board",)
        assert supports.balance.stays("board") is stays, (x, mass)


def test_the_weight_of_a_whole_pile_counts(cell: Cell) -> None:
    """Two on each other press at the middle of both, weighted by their masses."""
    foot = at(cell, "foot", shaped(cell, (0.04, 0.04, 0.05), mass=1.0), 0.3, 0.0, 0.025)
    board = at(cell, "board", shaped(cell, (0.2, 0.2, 0.01), mass=0.2), 0.3, 0.0, 0.055)
    lower = at(cell, "lower", shaped(cell, (0.06, 0.02, 0.02), mass=0.2), 0.3, 0.0, 0.07)
    for mass, stays in ((0.2, True), (4.0, False)):
        upper = at(cell, "upper", shaped(cell, (0.02, 0.02, 0.02), mass=mass), 0.326, 0.0, 0.09)
        supports = of(cell, foot, board, lower, upper)
        assert supports.graph.carriers("upper") == ("lower",)
        assert supports.balance.stays("board") is stays


@pytest.mark.parametrize(("angle", "stays"), [(9.9, False), (10.1, True), (20.0, True)])
def test_what_can_roll_stays_if_a_tilt_of_ten_degrees_does_not_bring_it_over_an_edge(
    cell: Cell, angle: float, stays: bool
) -> None:
    supports = in_a_slot(cell, angle)
    assert set(supports.graph.carriers("can")) == {"plate-1", "plate1"}
    assert supports.balance.stays("can") is stays
    assert not supports.balance.stays("can", {"plate1"})


@pytest.mark.parametrize("noise", [0.0, 1.0])
@pytest.mark.parametrize(("more", "stays"), [(-0.1, True), (0.1, False)])
def test_a_face_lies_flat_as_long_as_it_may_be_askew(
    cell: Cell, noise: float, more: float, stays: bool
) -> None:
    """A degree and a half as they lie, or what the poses of both may be off; beyond that over an edge."""
    turn, half = float(np.radians(max(1.5, 2 * noise) + more)), 0.02
    z = half * np.cos(turn) + half * np.sin(turn)
    box = at(cell, "box", shaped(cell, (0.04, 0.04, 0.04)), 0.3, 0.0, z, (0.0, turn, 0.0))
    assert of(cell, box, noise=PoseNoise(0.0, float(np.radians(noise)))).balance.stays("box") is stays


def test_what_is_only_squeezed_between_its_neighbours_slips(cell: Cell) -> None:
    """A friction of 0.2 on two walls takes five times the weight: so much presses nobody."""
    wall = shaped(cell, (0.05, 0.1, 0.2))
    walls = [at(cell, f"wall{s}", wall, 0.3 + s * 0.055, 0.0, 0.1) for s in (-1, 1)]
    squeezed = at(cell, "squeezed", shaped(cell, (0.06, 0.06, 0.06)), 0.3, 0.0, 0.08)
    below = at(cell, "below", shaped(cell, (0.06, 0.06, 0.05)), 0.3, 0.0, 0.025)
    supports = of(cell, *walls, squeezed, below)
    assert {c.b for c in supports.graph.touching["squeezed"]} >= {"wall-1", "wall1", "below"}
    assert supports.balance.stays("squeezed") and not supports.balance.stays("squeezed", {"below"})


def test_what_stands_beside_presses_on_nothing(cell: Cell) -> None:
    """However heavy it is: a board on one foot keeps its balance beside it."""
    foot = at(cell, "foot", shaped(cell, (0.04, 0.04, 0.05)), 0.3, 0.0, 0.025)
    board = at(cell, "board", shaped(cell, (0.2, 0.1, 0.01)), 0.3, 0.0, 0.055)
    heavy = at(cell, "heavy", shaped(cell, (0.05, 0.1, 0.1), mass=5.0), 0.425, 0.0, 0.05)
    supports = of(cell, foot, board, heavy)
    assert "heavy" in {c.b for c in supports.graph.touching["board"]}
    assert supports.balance.stays("board")


def test_what_a_body_carries_it_carries_up_to_its_edge(cell: Cell) -> None:
    """However badly the item's pose is known: where the bodies of the cell stand is known."""
    boom = next(body for body in cell.obstacles.bodies if body.name == "camera_boom")
    corner = boom.T_parent_shape[:3, 3] + boom.shape.extents / 2
    for inside, stays in ((0.001, True), (-0.001, False)):
        T = pose(corner + np.array([-inside, -boom.shape.extents[1] / 2, 0.01]))
        box = PlacedItem("box", shaped(cell, (0.05, 0.02, 0.02)), TOTE, T)
        supports = of(cell, box, noise=PoseNoise(0.004, 0.0))
        assert "camera_boom" in supports.graph.carriers("box") and supports.balance.stays("box") is stays


@pytest.mark.parametrize("direction", [(1, 0), (-1, 0), (0, 1), (0, -1)])
def test_a_press_beside_the_carrier_tips_what_is_too_light_to_stay(
    cell: Cell, direction: tuple[int, int]
) -> None:
    """1 N of weight, or a tenth more, 50 mm inside the edge balance 2 N of a press up to 25 mm beyond it."""
    below = at(cell, "below", shaped(cell, (0.1, 0.1, 0.05)), 0.3, 0.0, 0.025)
    above = at(cell, "above", shaped(cell, (0.2, 0.2, 0.02), mass=1.0 / 9.81 / 0.9), 0.3, 0.0, 0.06)
    supports = of(cell, below, above)
    centre, press = above.T_world_item[:3, 3], np.array([0.0, 0.0, -2.0])
    for beside, stays in ((0.0, True), (0.0745, True), (0.0755, False)):
        point = centre + np.array([*(beside * d for d in direction), 0.01])
        assert supports.balance.stays_under("above", press, point) is stays
        assert supports.balance.stays_under("above", 1e-3 * press, point)
    assert not supports.balance.stays_under("above", -press, centre)  # pulled off


@pytest.mark.parametrize("degrees", [0.0, 6.0])
def test_what_one_contact_bears_by_itself_balances(
    cell: Cell, degrees: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The short answer is the long one's, wherever on a face the press is, square on it or not."""
    below, above = on_a_slope(cell, degrees, 0.3, 0.05)
    supports, T = of(cell, below, above), above.T_world_item
    places = np.linspace(-0.6, 0.6, 7) * above.item.shape.extents.max()
    asked = [
        (T[:3, :3] @ [aside, 0.0, -3.0], T[:3, 3] + T[:3, :3] @ [x, y, 0.02])
        for x in places for y in places for aside in (0.0, 0.5, 1.0)
    ]  # fmt: skip
    short = [supports.balance.stays_under(above.id, *press) for press in asked]
    monkeypatch.setattr("pickcli.statics.balance.bears", lambda *_: False)
    assert short == [supports.balance.stays_under(above.id, *press) for press in asked]
    assert 10 < sum(short) < len(short) - 10


def test_what_one_contact_bears_needs_no_search_for_forces(
    cell: Cell, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pickcli.statics.balance.can_balance", lambda *_: False)
    below = at(cell, "below", shaped(cell, (0.1, 0.1, 0.05)), 0.3, 0.0, 0.025)
    above = at(cell, "above", shaped(cell, (0.06, 0.06, 0.02)), 0.3, 0.0, 0.06)
    balance, press = of(cell, below, above).balance, np.array([0.0, 0.0, -2.0])
    for beside, is_borne in ((0.0, True), (0.029, True), (0.031, False)):
        point = above.T_world_item[:3, 3] + [beside, 0.0, 0.01]
        assert balance.stays_under("above", press, point) is is_borne
    overhanging = replace(above, T_world_item=above.T_world_item @ pose((0.06, 0.0, 0.0)))
    inside = overhanging.T_world_item[:3, 3] - [0.02, 0.0, 0.0]
    assert not of(cell, below, overhanging).balance.stays_under("above", press, inside)  # its own weight


@pytest.mark.parametrize(("noise", "is_kept"), [(EXACT, False), (NOISY, True)])
def test_where_poses_may_be_off_what_lies_on_an_item_may_keep_it_with_more_than_its_weight_as_seen(
    cell: Cell, noise: PoseNoise, is_kept: bool
) -> None:
    """A plank with its middle 5 mm beside its pier, as it is seen, and little on its inner end."""
    pier = at(cell, "pier", shaped(cell, (0.1, 0.1, 0.1)), 0.3, 0.0, 0.05)
    plank = at(cell, "plank", shaped(cell, (0.2, 0.1, 0.02), mass=0.2), 0.245, 0.0, 0.11)
    weight = at(cell, "weight", shaped(cell, (0.02, 0.04, 0.02), mass=0.01), 0.3, 0.0, 0.13)
    apart = at(cell, "apart", shaped(cell, (0.02, 0.02, 0.02), mass=0.01), 0.4, 0.0, 0.01)
    balance = of(cell, pier, plank, weight, apart, noise=noise).balance
    assert balance.is_tipping("plank", "weight") is is_kept
    assert not balance.is_tipping("plank", "apart")


@pytest.mark.parametrize(("short", "is_kept"), [(0.8e-3, False), (1.2e-3, True)])
def test_a_balance_that_gets_worse_by_a_thousandth_of_the_weight_is_lost(
    cell: Cell, short: float, is_kept: bool
) -> None:
    """A plank with its middle beside its pier by that share of its half length, and as much on its end."""
    half = 0.1
    pier = at(cell, "pier", shaped(cell, (0.1, 0.1, 0.1)), 0.3, 0.0, 0.05)
    plank = at(cell, "plank", shaped(cell, (2 * half, 0.1, 0.02)), 0.25 - short * half, 0.0, 0.11)
    weight = at(cell, "weight", shaped(cell, (0.02, 0.04, 0.02)), 0.3, 0.0, 0.13)
    assert of(cell, pier, plank, weight).balance.is_tipping("plank", "weight") is is_kept


def test_a_contact_that_is_only_possible_bears_no_press(cell: Cell) -> None:
    """A plate that reaches over another by less than both poses may be off."""
    below = at(cell, "below", shaped(cell, (0.1, 0.1, 0.05)), 0.3, 0.0, 0.025)
    above = at(cell, "above", shaped(cell, (0.1, 0.1, 0.02)), 0.3 + 0.0985, 0.0, 0.06)
    supports = of(cell, below, above, noise=PoseNoise(0.002, 0.0))
    assert "below" in supports.graph.carriers("above")
    assert not supports.balance.stays_under("above", np.array([0.0, 0.0, -1.0]), above.T_world_item[:3, 3])


def test_what_lies_on_an_item_does_not_hold_it_against_a_press(cell: Cell) -> None:
    below = at(cell, "below", shaped(cell, (0.1, 0.1, 0.05)), 0.3, 0.0, 0.025)
    board = at(cell, "board", shaped(cell, (0.2, 0.1, 0.02), mass=0.1), 0.3, 0.0, 0.06)
    weight = at(cell, "weight", shaped(cell, (0.04, 0.04, 0.04), mass=0.1), 0.22, 0.0, 0.09)
    point = board.T_world_item[:3, 3] + [0.09, 0.0, 0.01]
    assert not of(cell, below, board, weight).balance.stays_under("board", np.array([0.0, 0.0, -4.0]), point)


def test_a_press_tips_what_it_is_beside_the_carriers_of_and_not_what_it_is_between(cell: Cell) -> None:
    """A light board on a carrier 80 mm to one side of its middle and on one 30 mm to the other."""
    far = at(cell, "far", shaped(cell, (0.04, 0.1, 0.05)), 0.22, 0.0, 0.025)
    near = at(cell, "near", shaped(cell, (0.04, 0.1, 0.05)), 0.33, 0.0, 0.025)
    board = at(cell, "board", shaped(cell, (0.24, 0.1, 0.02), mass=0.05), 0.3, 0.0, 0.06)
    supports, press = of(cell, far, near, board), np.array([0.0, 0.0, -4.0])
    for along, stays in ((-0.08, True), (0.03, True), (0.08, False)):
        point = board.T_world_item[:3, 3] + [along, 0.0, 0.01]
        assert supports.balance.stays_under("board", press, point) is stays
