"""Coefficients of the table, and stripes whose cover is known."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.watching.retroreflection import BAND_HEIGHTS, STRIPE, retroreflection, stripe_cover


def one(value: float) -> np.ndarray:
    return np.array([value])


@pytest.mark.parametrize(
    ("observation", "entrance", "coefficient"),
    [(0.2, 5.0, 330.0), (1.0, 0.0, 25.0), (1 / 3, 30.0, 250.0 * 0.55), (0.05, 0.0, 330.0), (1.0, 80.0, 0.0)],
)
def test_retroreflection_of_the_table(observation: float, entrance: float, coefficient: float) -> None:
    found = retroreflection(one(np.radians(observation)), one(np.radians(entrance)))
    assert found[0] == pytest.approx(coefficient)


def test_retroreflection_is_log_linear_between_angles() -> None:
    found = retroreflection(one(np.radians(1.25)), one(0.0))
    assert found[0] == pytest.approx(np.sqrt(25.0 * 10.0))


def test_stripe_cover_of_pixels_on_beside_and_across_stripes() -> None:
    side = np.pi / 2 + 0.0  # between two shoulders
    small, large = one(0.01), one(2 * STRIPE)
    on = stripe_cover(one(side), one(BAND_HEIGHTS[0]), small, small)
    beside = stripe_cover(one(side), one(BAND_HEIGHTS[0] + 0.1), small, small)
    whole = stripe_cover(one(side), one(BAND_HEIGHTS[0]), small, large)
    assert (on[0], beside[0], whole[0]) == pytest.approx((1.0, 0.0, 0.5))
    shoulder = stripe_cover(one(np.radians(30.0)), one(1.1), small, small)
    below = stripe_cover(one(np.radians(30.0)), one(0.9), small, small)
    assert (shoulder[0], below[0]) == pytest.approx((1.0, 0.0))
