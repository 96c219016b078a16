"""Scans of walls and legs whose ranges are known."""

from __future__ import annotations

import numpy as np
import pytest

from support.watched import hall, scene, watch

SCANNER = watch().scanner
NO_DISCS = np.zeros((0, 3))


def beam(degrees: float) -> int:
    return int(np.abs(SCANNER.angles - np.radians(degrees)).argmin())


def test_a_scan_covers_270_degrees_each_half_degree() -> None:
    np.testing.assert_allclose(np.degrees(SCANNER.angles[[0, -1]]), [-135.0, 135.0], atol=0.3)
    np.testing.assert_allclose(np.degrees(np.diff(SCANNER.angles)), 0.5, atol=1e-3)


def test_ranges_to_the_walls_of_a_hall() -> None:
    found = SCANNER.ranges(np.array([3.0, 4.0, 0.0]), scene(area=hall(length=10.0)).segments(0.2), NO_DISCS)
    assert found[beam(0)] == pytest.approx(10.0 - 3.0 - SCANNER.forward)
    assert found[beam(90)] == pytest.approx(4.0, rel=1e-4) and found[beam(-90)] == pytest.approx(
        4.0, rel=1e-4
    )
    turned = SCANNER.ranges(np.array([3.0, 4.0, np.pi / 2]), scene(area=hall()).segments(0.2), NO_DISCS)
    assert turned[beam(0)] == pytest.approx(4.0 - SCANNER.forward)


def test_ranges_to_a_disc_end_at_its_edge_and_what_is_far_is_not_measured() -> None:
    disc = np.array([[SCANNER.forward + 2.0, 0.0, 0.1]])
    found = SCANNER.ranges(np.zeros(3), np.zeros((0, 2, 2)), disc)
    assert found[beam(0)] == pytest.approx(1.9)
    assert np.count_nonzero(found < SCANNER.farthest) == 2 * int(np.degrees(np.arcsin(0.05)) / 0.5) + 1
    assert found[beam(60)] == SCANNER.farthest
    behind = SCANNER.ranges(np.array([5.0, 0.0, 0.0]), np.zeros((0, 2, 2)), np.array([[2.0, 0.0, 0.1]]))
    assert (behind == SCANNER.farthest).all()


def test_low_boxes_are_below_the_plane() -> None:
    from pickcli.driving.driving_area import FloorBox

    area = hall(FloorBox("step", (6.0, 4.0), (1.0, 1.0)))
    high, low = (
        SCANNER.ranges(area.start, scene(area=area, box_height=height).segments(SCANNER.above), NO_DISCS)
        for height in (0.5, 0.1)
    )
    assert high[beam(0)] == pytest.approx(5.5 - 1.5 - SCANNER.forward)
    assert low[beam(0)] == SCANNER.farthest


def test_noise_is_of_its_size_and_the_same_by_seed() -> None:
    true = np.full(len(SCANNER.angles), 3.0)
    true[:100] = SCANNER.farthest
    found = SCANNER.measured(true, np.random.default_rng(2))
    assert (found[:100] == SCANNER.farthest).all()
    assert (found[100:] - 3.0).std() == pytest.approx(SCANNER.noise, rel=0.15)
    np.testing.assert_array_equal(found, SCANNER.measured(true, np.random.default_rng(2)))


def test_points_are_where_ranges_end() -> None:
    points = SCANNER.points(np.full(len(SCANNER.angles), 2.0))
    np.testing.assert_allclose(points[beam(0)], [SCANNER.forward + 2.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(points[beam(90)], [SCANNER.forward, 2.0], atol=1e-3)
