"""The pace of lines on a belt: a belt that changes its speed as it may adds no more jerk than they leave."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.robot import Limits
from pickcli.motion.plan import times_at_work
from pickcli.planning.belt_picks.line_pace import KEPT, MOST_PACED, line_pace
from support.belt_picks import belt_pick, cell


@given(st.floats(0.0, 20.0), st.lists(st.floats(0.5, 20.0), min_size=1, max_size=8), st.integers(10, 40))
def test_jerk_of_lines_and_of_a_change_of_pace_fit_the_limit(
    change: float, accelerations: list[float], ratio: int
) -> None:
    acceleration = np.array(accelerations)
    rows = np.ones_like(acceleration)
    p = line_pace(Limits(-rows, rows, rows, acceleration, ratio * acceleration), change)
    jerk = p * (ratio * acceleration + 3.0 * change * acceleration) / (ratio * acceleration)
    assert 0.0 < p <= MOST_PACED
    assert float(jerk.max()) <= KEPT + 1e-9


@pytest.mark.parametrize("speed", [0.1, 0.33])
def test_the_lines_of_a_plan_leave_that_room(speed: float) -> None:
    plan, limits = belt_pick(speed).plan, cell().robot.limits
    belt = cell().carriers["belt"].conveyor
    assert belt is not None
    t_works, t_left = times_at_work(plan.segments)
    t = np.linspace(t_works + 1e-3, t_left - 1e-3, 3000)
    acceleration, jerk = (np.abs(plan.trajectory.sample(t, k)) for k in (2, 3))
    used = (jerk + 3.0 * belt.max_acceleration / speed * acceleration) / limits.jerk
    assert 0.5 < float(used.max()) <= 1.0
