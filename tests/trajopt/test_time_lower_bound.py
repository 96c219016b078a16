"""The lower bound, with ruckig as its oracle."""

from __future__ import annotations

import numpy as np
import pytest
import ruckig
from hypothesis import given
from hypothesis import strategies as st

from pickcli.trajopt.time_lower_bound import least_durations

logarithmic = st.floats(-3.0, 1.0).map(lambda x: 10.0**x)


@given(logarithmic, logarithmic, logarithmic, st.floats(-3.0, 0.0).map(lambda x: 10.0**x))
def test_one_joint_takes_what_ruckig_takes(
    distance: float, velocity: float, acceleration: float, ramp: float
) -> None:
    given_, plan = ruckig.InputParameter(1), ruckig.Trajectory(1)
    given_.target_position, given_.max_velocity = [distance], [velocity]
    given_.max_acceleration, given_.max_jerk = [acceleration], [acceleration / ramp]
    ruckig.Ruckig(1).calculate(given_, plan)
    found = least_durations(*(np.array([x]) for x in (distance, velocity, acceleration, ramp)))
    assert found[0] == pytest.approx(plan.duration, rel=1e-6)


def test_without_jerk_limit_it_is_a_trapezoid_or_a_triangle() -> None:
    found = least_durations(
        np.array([2.0, 1.0, 0.0]), np.array([1.0, 9.0, 1.0]), np.array([2.0, 4.0, 1.0]), np.zeros(3)
    )
    np.testing.assert_allclose(found, [2.5, 1.0, 0.0])
