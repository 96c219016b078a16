"""Polygons that bear: against scipy's hulls, and point by point."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from pickcli.geometry import Array
from pickcli.palletizing.support_polygon import clipped, depth_inside, hull, rectangle

LOW, HIGH = np.array([-0.2, -0.1]), np.array([0.3, 0.2])


def points(seed: int, n: int) -> Array:
    return np.random.default_rng(seed).uniform(-0.5, 0.5, (n, 2))


@given(st.integers(0, 10_000), st.integers(4, 40))
@settings(deadline=None)
def test_a_hull_is_that_of_scipy(seed: int, n: int) -> None:
    cloud = points(seed, n)
    found, oracle = hull(cloud), ConvexHull(cloud)
    assert sorted(map(tuple, found.tolist())) == sorted(map(tuple, cloud[oracle.vertices].tolist()))
    shifted = np.roll(found, -1, axis=0)
    assert np.sum(found[:, 0] * shifted[:, 1] - found[:, 1] * shifted[:, 0]) / 2 == pytest.approx(
        oracle.volume
    )


@given(st.integers(0, 10_000))
@settings(deadline=None)
def test_a_point_is_in_what_is_clipped_if_it_is_in_both(seed: int) -> None:
    polygon = hull(points(seed, 8))
    part = clipped(polygon, LOW, HIGH)
    for point in points(seed + 1, 50):
        depths = depth_inside(polygon, point[None]), depth_inside(rectangle(LOW, HIGH), point[None])
        if min(map(abs, depths)) > 1e-9:
            assert (depth_inside(hull(part), point[None]) > 0.0) is (min(depths) > 0.0)


def test_how_far_inside_points_are() -> None:
    square = rectangle(LOW, HIGH)
    assert depth_inside(square, np.array([[0.0, 0.05]])) == pytest.approx(0.15)
    assert depth_inside(square, np.array([[0.0, 0.05], [0.32, 0.0]])) == pytest.approx(-0.02)
    assert depth_inside(square[:2], np.array([[0.0, 0.0]])) == -np.inf


def test_a_hull_of_points_on_a_line_has_no_area() -> None:
    assert len(hull(np.outer(np.arange(5.0), [1.0, 2.0]))) == 2
    assert len(clipped(rectangle(LOW, HIGH), HIGH + 1.0, HIGH + 2.0)) == 0
