"""Where people are, how fast they walk, and where their legs are."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.watching.watched_scene import APART, LEG, SWING, Reflector, ReflectorKind, Walker
from support.watched import BOX, hall, scene

CORNER = Walker("ann", ((1.0, 1.0), (4.0, 1.0), (4.0, 3.0)), 1.5, 2.0)


def test_a_walk_along_a_route_with_a_corner() -> None:
    for time, place in (
        (0.0, (1, 1)),
        (2.0, (1, 1)),
        (3.0, (2.5, 1)),
        (4.0, (4, 1)),
        (5.0, (4, 2.5)),
        (9.0, (4, 3)),
    ):
        np.testing.assert_allclose(CORNER.place(time), place, atol=1e-12)
    assert CORNER.heading(3.0) == 0.0 and CORNER.heading(5.0) == pytest.approx(np.pi / 2)
    np.testing.assert_array_equal(CORNER.velocity(1.0), [0.0, 0.0])
    np.testing.assert_array_equal(CORNER.velocity(9.0), [0.0, 0.0])


@given(st.floats(2.01, 5.3).filter(lambda t: abs(t - 4.0) > 0.01))
def test_velocity_is_the_derivative_of_the_place(time: float) -> None:
    step = 1e-5
    difference = (CORNER.place(time + step) - CORNER.place(time - step)) / (2 * step)
    np.testing.assert_allclose(CORNER.velocity(time), difference, atol=1e-6)


@given(st.floats(0.0, 10.0))
def test_legs_are_beside_the_body_and_swing_against_each_other(time: float) -> None:
    legs = CORNER.legs(time)
    np.testing.assert_allclose(legs[:, :2].mean(axis=0), CORNER.place(time), atol=1e-12)
    apart = np.hypot(*(legs[0, :2] - legs[1, :2]))
    assert 2 * APART - 1e-9 <= apart <= 2 * np.hypot(APART, SWING) + 1e-9
    assert (legs[:, 2] == LEG).all()


def test_someone_with_one_place_stands() -> None:
    bob = Walker("bob", ((2.0, 3.0),), 1.0)
    np.testing.assert_array_equal(bob.place(7.0), [2.0, 3.0])
    np.testing.assert_array_equal(bob.velocity(7.0), [0.0, 0.0])


def test_segments_and_discs_are_all_that_stands_in_the_plane() -> None:
    post = Reflector(ReflectorKind.POST, (3.0, 3.0, 0.5), (0.1, 1.0))
    sign = Reflector(ReflectorKind.SIGN, (3.0, 3.0, 1.5), (0.4, 0.4))
    of = scene(CORNER, area=hall(BOX), reflectors=(post, sign))
    assert of.segments(0.2).shape == (8, 2, 2) and of.segments(2.5).shape == (4, 2, 2)
    assert of.discs(0.0)[0].tolist() == [3.0, 3.0, 0.05] and len(of.discs(0.0)) == 3
