"""Parts of trajectories."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.motion.trajectory import Trajectory


def trajectory() -> Trajectory:
    t = np.array([0.0, 0.5, 0.7, 1.5, 2.0])
    rows = (np.column_stack([t**k, -(t**k)]) for k in (3, 2, 1))
    return Trajectory(("a", "b"), t, *rows)


def test_the_part_between_two_points_is_the_same_motion_from_zero_on() -> None:
    whole, part = trajectory(), trajectory().between(0.5, 1.5)
    np.testing.assert_allclose(part.times, [0.0, 0.2, 1.0])
    t = np.linspace(0.0, 1.0, 13)
    for derivative in range(3):
        np.testing.assert_allclose(part.sample(t, derivative), whole.sample(t + 0.5, derivative), atol=1e-12)


@pytest.mark.parametrize(("tolerance", "n"), [(1e-9, 2), (1e-6, 3)])
def test_a_point_that_is_off_by_less_than_the_tolerance_is_one_of_them(tolerance: float, n: int) -> None:
    assert len(trajectory().between(0.5 + 1e-7, 1.5, tolerance).times) == n
