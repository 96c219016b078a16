"""What one contact bears and what several balance: statics by hand, on both sides of every bound."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.geometry import Array, perpendiculars, pose
from pickcli.statics.solid_contact import (
    CARRYING_NORMAL_Z,
    FRICTION,
    MOST_FORCE,
    SolidContact,
    bears,
    can_balance,
    friction_cones,
    missing_to_balance,
)
from support.bin_piles import at, of, shaped

UP = np.array([0.0, 0.0, 1.0])
SQUARE = np.array([[0.5, 0.5, 2.0], [-0.5, 0.5, 2.0], [-0.5, -0.5, 2.0], [0.5, -0.5, 2.0]])  # m, 2 m up
TURNS = [np.eye(3), pose(rpy=(0.4, -0.7, 1.9))[:3, :3]]


@pytest.mark.parametrize("R", TURNS)
@pytest.mark.parametrize("factor", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize(
    ("slope", "height", "x", "is_borne"),
    [
        (0.0, 1.0, 0.499, True), (0.0, 1.0, 0.501, False),
        (0.0, 1.0, -0.499, True), (0.0, 1.0, -0.501, False),
        (0.19, 1.0, 0.3, True), (0.21, 1.0, 0.0, False), (-0.21, 1.0, 0.0, False),
        (0.19, 1.0, 0.32, False), (0.19, 1.0, -0.68, True), (0.19, 1.0, -0.7, False), (0.1, 3.0, 0.19, True),
        (0.1, 3.0, 0.21, False), (0.1, -1.0, 0.59, True), (0.1, -1.0, 0.61, False),
    ],
)  # fmt: skip
def test_a_contact_bears_a_force_whose_line_leads_steeply_through_it(
    R: Array, factor: float, slope: float, height: float, x: float, is_borne: bool
) -> None:
    """Down and aside by a slope along x, from a height over the contact, in any frame and unit of force."""
    aside, _ = perpendiculars(R @ UP)
    along = np.column_stack([aside, np.cross(R @ UP, aside), R @ UP])  # the square, turned to those axes
    force, point = factor * np.array([slope, 0.0, -1.0]), np.array([x, 0.1, 2.0 + height])
    assert bears(SQUARE @ along.T, R @ UP, along @ force, along @ point) is is_borne


def test_nothing_bears_without_a_patch_or_what_pulls_or_leads_along() -> None:
    down, above = -UP, np.array([0.1, 0.1, 3.0])
    assert bears(SQUARE, UP, down, above)
    assert not bears(np.empty((0, 3)), UP, down, above)
    assert not bears(SQUARE, UP, UP, above)
    assert not bears(SQUARE, UP, np.zeros(3), above)
    assert not bears(SQUARE, UP, np.array([1.0, 0.0, 0.0]), above)
    assert not bears(SQUARE, UP, down, np.array([0.5, 0.0, 3.0]))  # over the very edge
    assert not bears(SQUARE[:2], UP, down, np.array([0.0, 0.5, 3.0]))  # an edge bears nothing by itself


def test_friction_bears_up_to_its_very_share() -> None:
    aside, other = perpendiculars(UP)
    for way in (aside, -aside, other, -other):
        for share, is_borne in ((1.0, True), (1.001, False)):
            force = FRICTION * share * way - UP
            assert bears(SQUARE, UP, force, np.array([0.0, 0.0, 2.0])) is is_borne


def test_a_contact_carries_from_its_slope_on() -> None:
    level = float(np.sqrt(1.0 - CARRYING_NORMAL_Z**2))
    for z, carries in (
        (-1.0, True),
        (-CARRYING_NORMAL_Z, True),
        (-CARRYING_NORMAL_Z + 1e-9, False),
        (0.0, False),
        (CARRYING_NORMAL_Z, False),
    ):
        contact = SolidContact("a", "b", 0.001, np.array([level, 0.0, z]))
        assert contact.carries is carries
        flipped = contact.flipped
        assert (flipped.a, flipped.b, flipped.gap) == ("b", "a", 0.001)
        np.testing.assert_array_equal(flipped.normal, -contact.normal)


def test_every_corner_may_push_along_the_four_edges_of_its_cone() -> None:
    arms = np.array([[0.1, 0.2, -0.3], [0.0, 0.5, 0.1], [1.0, 0.0, 0.0]])
    cones, (u, v) = friction_cones(arms, UP), perpendiculars(UP)
    assert cones.shape == (6, 12)
    expected = [
        np.concatenate([force, np.cross(arm, force)])
        for arm in arms
        for force in (UP + FRICTION * u, UP - FRICTION * u, UP + FRICTION * v, UP - FRICTION * v)
    ]
    np.testing.assert_allclose(cones.T, expected, atol=1e-15)


def feet(half: float, normal: Array = UP) -> Array:
    """Four points at so many m from the middle, below it."""
    return friction_cones(np.array([[x, y, -0.1] for x in (-half, half) for y in (-half, half)]), normal)


@pytest.mark.parametrize("size", [0.05, 1.0])
def test_what_stands_on_four_feet_balances_while_its_weight_is_between_them(size: float) -> None:
    """The weight acts beside the middle, as if something lay there."""
    for beside, holds in ((0.0, True), (0.029, True), (0.031, False), (-0.029, True), (-0.031, False)):
        for about in (beside * np.eye(3)[0], beside * np.eye(3)[1]):
            assert can_balance(feet(0.03), np.concatenate([UP, about]), size) is holds
    # Level by as much as friction bears; that it pushes below the middle is part of what must balance.
    for aside, holds in ((0.19, True), (0.21, False)):
        u, _ = perpendiculars(UP)
        force = aside * u + UP
        torque = np.cross([0.0, 0.0, -0.1], force)
        assert can_balance(feet(0.03), np.concatenate([force, torque]), size) is holds


def test_contacts_push_with_a_limited_force_and_never_pull() -> None:
    assert not can_balance(feet(0.03), np.array([0.0, 0.0, -1.0, 0.0, 0.0, 0.0]), 0.1)
    for weights, holds in ((MOST_FORCE - 1e-3, True), (MOST_FORCE + 1e-3, False)):
        assert can_balance(feet(0.03), np.array([0.0, 0.0, weights, 0.0, 0.0, 0.0]), 0.1) is holds


@pytest.mark.parametrize("size", [0.1, 1.0, 10.0])
def test_what_presses_by_its_weight_alone_presses_with_no_more(size: float) -> None:
    up, turn = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]), np.array([0.0, 0.0, 0.0, 0.0, 1.0, 0.0])
    three = np.column_stack([up, up, up])
    for limits, missing in (
        ([], 0.0), ([(1, 0.3)], 0.0), ([(1, 0.3), (2, 0.5)], 0.2), ([(2, 0.5), (1, 0.3)], 0.2),
        ([(3, 0.4)], 0.6), ([(3, 1.5)], 0.0),
    ):  # fmt: skip
        assert missing_to_balance(three, up, size, limits) == pytest.approx(missing, abs=1e-9)
    # What nothing turns back counts by its lever at the size; forces that pull are none.
    assert missing_to_balance(three, up + turn, size, []) == pytest.approx(1.0 / size, abs=1e-9)
    assert missing_to_balance(three, -up, size, []) == pytest.approx(1.0, abs=1e-9)


def test_the_footing_of_an_item_is_where_it_lies_on_what_carries_it(cell: Cell) -> None:
    below = at(cell, "below", shaped(cell, (0.1, 0.1, 0.05)), 0.3, 0.0, 0.025)
    above = at(cell, "above", shaped(cell, (0.06, 0.04, 0.02)), 0.33, 0.0, 0.06)
    beside = at(cell, "beside", shaped(cell, (0.05, 0.1, 0.12)), 0.385, 0.0, 0.06)
    found = of(cell, below, above, beside).balance.footing("above")
    local = (found - above.T_world_item[:3, 3]) @ above.T_world_item[:3, :3]
    corners = sorted({tuple(p) for p in local.round(6).tolist()})
    assert corners == sorted([(x, y, -0.01) for x in (-0.03, 0.02) for y in (-0.02, 0.02)])


SINE_OF_20 = 0.3420201433256687
STEEPEST = 0.4472135954999579  # level part of the normal of a slope of 1 to 2


@pytest.mark.parametrize(
    ("normal", "carries", "is_steep"),
    [
        ((0.0, 0.0, -1.0), True, False),
        ((0.9, 0.0, -SINE_OF_20), True, True),
        ((0.9, 0.0, -SINE_OF_20 + 1e-9), False, True),
        ((0.0, STEEPEST, -0.9), True, False),
        ((0.0, -STEEPEST - 1e-9, -0.9), True, True),
        ((0.0, 0.0, 1.0), False, False),
    ],
)
def test_a_contact_carries_up_to_seventy_degrees_and_is_steep_beyond_a_slope_of_one_to_two(
    normal: tuple[float, float, float], carries: bool, is_steep: bool
) -> None:
    contact = SolidContact("a", "b", 0.0, np.array(normal))
    assert (contact.carries, contact.is_steep) == (carries, is_steep)


def test_a_force_may_lean_by_the_very_friction() -> None:
    for slope, is_borne in ((FRICTION, True), (np.nextafter(FRICTION, 1.0), False)):
        assert bears(SQUARE, UP, np.array([slope, 0.0, -1.0]), np.array([0.0, 0.0, 2.0])) is is_borne


@pytest.mark.parametrize("axis", range(6))
@pytest.mark.parametrize("size", [0.125, 0.5])
def test_a_millionth_of_the_weight_or_of_that_at_half_the_size_may_be_left_over(
    axis: int, size: float
) -> None:
    """Of a force, and of a torque, where nothing pushes at all."""
    most = 1e-6 if axis < 3 else 1e-6 * size
    for left, holds in ((most, True), (-most, True), (1.001 * most, False)):
        assert can_balance(np.zeros((6, 1)), left * np.eye(6)[axis], size) is holds


def test_a_contact_pushes_with_four_weights_and_no_more() -> None:
    straight_up = np.eye(6)[:, 2:3]
    for weights, holds in ((4.0, True), (4.0 + 1e-9, False)):
        assert can_balance(straight_up, weights * np.eye(6)[2], 0.5) is holds
