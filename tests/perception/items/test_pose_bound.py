"""Bounds by the covariance of a pose."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.perception.items.pose_bound import LARGEST, joint_bound_of

COARSE, FINE = 1.2, 3.0  # pixels per mm


def covariance(mm: float, degrees: float) -> np.ndarray:
    """Of shifts and turns that do not depend on each other."""
    return np.diag(np.repeat([1e-3 * mm, np.radians(degrees)], 3) ** 2)


def test_bounds_grow_with_deviations(cell: Cell) -> None:
    item = cell.item("command_hooks", 2016)
    one, two = (joint_bound_of(item, covariance(k * 0.2, k * 0.1), FINE) for k in (1.0, 2.0))
    assert one is not None and two is not None
    assert one.displacement is not None and two.displacement is not None
    assert two.position == pytest.approx(2.0 * one.position)
    assert two.angle == pytest.approx(2.0 * one.angle)
    assert two.displacement == pytest.approx(2.0 * one.displacement)
    assert one.position > 3e-4 and one.displacement > one.position


def test_what_is_too_wide_to_be_of_use_is_none(cell: Cell) -> None:
    item = cell.item("command_hooks", 2016)
    assert joint_bound_of(item, covariance(1e3 * LARGEST.position, 0.1), FINE) is None
    assert joint_bound_of(item, covariance(0.2, 8.0), FINE) is None


def test_turns_that_a_shape_does_not_show_do_not_count(cell: Cell) -> None:
    bottle, ball = (cell.item(name, 2016) for name in ("dasani_water_bottle", "rawlings_baseball"))
    rolled = covariance(0.2, 0.1)
    rolled[5, 5] = np.radians(40.0) ** 2
    assert joint_bound_of(bottle, rolled, FINE) is not None
    assert joint_bound_of(cell.item("command_hooks", 2016), rolled, FINE) is None
    turned = covariance(0.2, 40.0)
    bound = joint_bound_of(ball, turned, FINE)
    assert bound is not None and bound.angle == 0.0


def test_bounds_are_wider_by_coarse_pictures(cell: Cell) -> None:
    item = cell.item("command_hooks", 2016)
    fine, coarse = (joint_bound_of(item, covariance(0.2, 0.1), per_mm) for per_mm in (FINE, COARSE))
    assert fine is not None and coarse is not None
    assert fine.displacement is not None and coarse.displacement is not None
    assert coarse.position > 2.0 * fine.position
    assert coarse.angle > fine.angle
    assert coarse.displacement > 1.6 * fine.displacement
