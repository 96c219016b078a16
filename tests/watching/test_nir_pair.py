"""Triangulation against projection, known answers, and covariances against drawn errors."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.watching.nir_pair import NirPair
from support.watched import watch

PAIR: NirPair = watch().pair


@given(st.floats(2.2, 21.0), st.floats(-10.0, 10.0), st.floats(0.0, 3.0))
def test_triangulated_is_the_inverse_of_projected(x: float, y: float, z: float) -> None:
    point = np.array([x, y, z])
    left, right = (PAIR.projected(point, is_right) for is_right in (False, True))
    np.testing.assert_allclose(PAIR.triangulated(left, right), point, atol=1e-9)
    assert left[1] == pytest.approx(right[1])


def test_projected_of_a_point_before_the_middle_of_both_cameras() -> None:
    """At the depth Z a point on the axis is f b / 2 Z px beside the middle of either picture."""
    point = np.array([PAIR.forward + 5.0, 0.0, PAIR.above])
    left, right = PAIR.projected(point, False), PAIR.projected(point, True)
    f = PAIR.width / 2 / np.tan(np.radians(50.0))
    assert left[0] - PAIR.camera.cx == pytest.approx(f * PAIR.baseline / 10, rel=1e-4)
    assert right[0] - PAIR.camera.cx == pytest.approx(-f * PAIR.baseline / 10, rel=1e-4)
    assert left[1] == pytest.approx(PAIR.camera.cy)


def test_the_field_of_view_is_that_of_the_file() -> None:
    edges = (np.array([-0.5, PAIR.width - 0.5]) - PAIR.camera.cx) / PAIR.camera.fx
    assert np.degrees(np.arctan(edges[1]) - np.arctan(edges[0])) == pytest.approx(100.0, abs=0.01)


@pytest.mark.parametrize("place", [(6.0, 0.0), (6.0, 4.0), (15.0, -7.0)])
def test_covariance_is_that_of_drawn_errors(place: tuple[float, float]) -> None:
    rng, n = np.random.default_rng(5), 20000
    point = np.array([*place, 1.2])
    sigma = PAIR.disparity_error / np.sqrt(2)
    left, right = (
        PAIR.projected(point, is_right) + sigma * rng.standard_normal((n, 1)) * [1.0, 0.0]
        for is_right in (False, True)
    )
    drawn = np.cov(PAIR.triangulated(left, right)[:, :2].T)
    stated = PAIR.covariance(point)
    np.testing.assert_allclose(stated, drawn, rtol=0.12, atol=0.02 * np.trace(drawn))
