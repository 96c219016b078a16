"""What a cup bears: corners worked out by hand, and laws that hold for every wrench."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.cell import Cell
from pickcli.cell.tools.cup_limits import CupLimits, twist_of
from pickcli.geometry import Array, rotation_axis_angle

LIMITS = CupLimits(max_pull=42.0, max_shear=21.0, max_moment=0.6, max_twist=0.21)
component = st.floats(-50.0, 50.0)
wrenches = st.tuples(*[component] * 6).map(np.array)
shares = st.floats(0.01, 1.0)


@pytest.mark.parametrize(
    ("wrench", "expected"),
    [
        ((0, 0, -42, 0, 0, 0), 1.0),  # pull alone
        ((0, 0, 42, 0, 0, 0), 0.0),  # pressed on
        ((21, 0, 0, 0, 0, 0), 1.0),
        ((0, 0, 0, 0.36, 0.48, 0), 1.0),  # bending, 3-4-5
        ((0, 0, 0, 0, 0, -0.21), 1.0),
        ((0, 0, -21, 0.3, 0, 0), 1.0),  # half the pull and half the bending lift the lip
        ((12.6, 0, 0, 0, 0, 0.168), 1.0),  # 0.6 of the shear and 0.8 of the twist let it slip
        ((12.6, 0, -21, 0.3, 0, 0), 1.0),  # the two do not add up
    ],
)
def test_ratio_by_hand(wrench: tuple[float, ...], expected: float) -> None:
    assert float(LIMITS.ratio(np.array(wrench, dtype=float))) == pytest.approx(expected, abs=1e-12)


@given(wrenches, st.floats(0.0, 5.0), shares)
def test_ratio_scales_with_the_wrench_and_falls_with_the_vacuum(
    wrench: Array, factor: float, share: float
) -> None:
    once = float(LIMITS.ratio(wrench))
    assert float(LIMITS.ratio(factor * wrench)) == pytest.approx(factor * once, rel=1e-9, abs=1e-12)
    assert float(LIMITS.ratio(wrench, share)) == pytest.approx(once / share, rel=1e-9)


@given(wrenches, st.floats(-np.pi, np.pi))
def test_ratio_is_the_same_turned_about_the_axis_of_the_cup(wrench: Array, angle: float) -> None:
    R = rotation_axis_angle((0.0, 0.0, 1.0), angle)
    turned = np.concatenate([R @ wrench[:3], R @ wrench[3:]])
    assert float(LIMITS.ratio(turned)) == pytest.approx(float(LIMITS.ratio(wrench)), rel=1e-9, abs=1e-12)


@given(wrenches, wrenches, st.floats(0.0, 1.0))
def test_ratio_is_convex(a: Array, b: Array, share: float) -> None:
    between = float(LIMITS.ratio(share * a + (1.0 - share) * b))
    assert between <= share * float(LIMITS.ratio(a)) + (1.0 - share) * float(LIMITS.ratio(b)) + 1e-9


@given(wrenches, st.floats(-1.0, 1.0))
def test_ratio_of_one_wrench_is_that_of_many_to_the_last_bit(wrench: Array, share: float) -> None:
    many = LIMITS.ratio(np.stack([wrench, wrench]), np.array([share, share]))
    np.testing.assert_array_equal(many, LIMITS.ratio(wrench, share))


def test_ratio_without_vacuum_is_infinite() -> None:
    assert LIMITS.ratio(np.zeros(6), 0.0) == np.inf
    np.testing.assert_array_equal(LIMITS.ratio(np.zeros((2, 6)), np.array([0.0, 1.0])), [np.inf, 0.0])


def test_twist_that_is_not_stated_is_that_of_a_uniformly_pressed_disc(cell: Cell) -> None:
    radius, n = 0.015, 2000  # friction per area times distance from the middle, summed over rings
    r = (np.arange(n) + 0.5) * radius / n
    summed = float(np.sum(21.0 / (np.pi * radius**2) * r * 2.0 * np.pi * r) * radius / n)
    assert twist_of(21.0, radius) == pytest.approx(summed, rel=1e-6)
    assert cell.robot.tool.cup.limits.max_twist == pytest.approx(0.21)


@given(wrenches)
def test_a_cup_of_which_nothing_is_said_has_its_full_vacuum(wrench: Array) -> None:
    for figure in (LIMITS.peel, LIMITS.slip, LIMITS.ratio):
        assert figure(wrench) == figure(wrench, 1.0)


def test_lip_and_slip_are_told_apart() -> None:
    """Pull and bending lift the lip, shear and twist let it slip; the worse of the two counts."""
    pull, shear = np.array([1.0, 2.0, -42.0, 0.0, 0.0, 0.0]), np.array([0.0, 42.0, -21.0, 0.0, 0.0, 0.0])
    assert (LIMITS.peel(pull), LIMITS.slip(pull)) == pytest.approx((1.0, np.sqrt(5.0) / 21.0))
    assert (LIMITS.peel(shear), LIMITS.slip(shear)) == pytest.approx((0.5, 2.0))
    assert (LIMITS.ratio(pull), LIMITS.ratio(shear)) == pytest.approx((1.0, 2.0))
    assert (LIMITS.peel(pull, 0.5), LIMITS.slip(shear, 0.5)) == pytest.approx((2.0, 4.0))


def test_a_share_below_nothing_bears_nothing() -> None:
    assert LIMITS.peel(np.ones(6), -0.5) == LIMITS.slip(np.ones(6), -0.5) == np.inf
