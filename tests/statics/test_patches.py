"""Patches: where faces, edges and points press on each other."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import pose
from pickcli.statics.patches import feature, patch

DOWN = np.array([0.0, 0.0, -1.0])
BOX = Shape(ShapeKind.BOX, (0.2, 0.1, 0.04))
CAN = Shape(ShapeKind.CYLINDER, (0.05, 0.12))
BALL = Shape(ShapeKind.SPHERE, (0.03,))
FLAT = float(np.radians(2.0))


@pytest.mark.parametrize(
    ("shape", "rpy", "count"),
    [
        (BOX, (0.0, 0.0, 0.7), 4),
        (BOX, (0.02, 0.0, 0.0), 4),  # askew by less than the tolerance
        (BOX, (0.3, 0.0, 0.0), 2),
        (BOX, (0.3, 0.4, 0.0), 1),
        (CAN, (0.0, 0.0, 0.0), 16),
        (CAN, (np.pi / 2, 0.0, 0.0), 2),
        (CAN, (0.5, 0.0, 0.0), 1),
        (BALL, (0.0, 0.0, 0.0), 1),
    ],
)  # fmt: skip
def test_what_lies_on_a_floor_is_a_face_an_edge_or_a_point(
    shape: Shape, rpy: tuple[float, float, float], count: int
) -> None:
    points = feature(shape, pose([0.1, 0.2, 0.3], rpy=rpy), DOWN, FLAT)
    assert len(points) == count
    lowest = 0.3 - float(shape.reach(pose(rpy=rpy)[:3, :3])[2])
    assert points[:, 2].min() == pytest.approx(lowest, abs=1e-9)


def area(points: np.ndarray) -> float:
    x, y = points[:, 0], points[:, 1]
    return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def test_a_box_half_over_another_presses_on_what_they_share() -> None:
    low = feature(BOX, pose(), -DOWN, FLAT)
    high = feature(BOX, pose([0.15, 0.02, 0.04]), DOWN, FLAT)
    met = patch(high, low, DOWN, 0.0)
    assert area(met) == pytest.approx(0.05 * 0.08, rel=1e-6)
    assert area(patch(high, low, DOWN, 0.01)) == pytest.approx(0.04 * 0.07, rel=1e-6)
    np.testing.assert_allclose(met[:, 2], 0.02, atol=1e-9)


def test_a_lying_can_presses_along_the_part_of_its_line_that_is_carried() -> None:
    low = feature(BOX, pose(), -DOWN, FLAT)
    line = feature(CAN, pose([0.0, 0.04, 0.07], rpy=[np.pi / 2, 0.0, 0.0]), DOWN, FLAT)
    met = patch(line, low, DOWN, 0.0)
    assert sorted(met[:, 1].round(6)) == [-0.02, 0.05]


def test_two_lying_cans_across_each_other_touch_in_a_point() -> None:
    below = feature(CAN, pose(rpy=[np.pi / 2, 0.0, 0.0]), -DOWN, FLAT)
    above = feature(CAN, pose([0.01, 0.02, 0.1], rpy=[0.0, np.pi / 2, 0.0]), DOWN, FLAT)
    met = patch(above, below, DOWN, 0.0)
    np.testing.assert_allclose(met, [[0.0, 0.02, 0.05]], atol=1e-9)


def test_what_misses_presses_nowhere() -> None:
    low = feature(BOX, pose(), -DOWN, FLAT)
    assert len(patch(feature(BALL, pose([0.3, 0.0, 0.05]), DOWN, FLAT), low, DOWN, 0.0)) == 0
    assert len(patch(feature(BOX, pose([0.3, 0.0, 0.04]), DOWN, FLAT), low, DOWN, 0.0)) == 0
