"""The distance of an event from its trigger, against a motion of one joint along a line."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.kinematics.arm import Arm
from pickcli.simulation.trigger import TriggerDistance
from support.rail_pick import rail_pick


@pytest.mark.parametrize("late", [-0.0103, -4e-4, 0.0, 3e-4, 0.0077])
def test_the_distance_is_that_of_the_tool_wherever_between_samples_it_is(cell: Cell, late: float) -> None:
    plan = rail_pick(cell)
    measure, event = TriggerDistance(plan, Arm(cell.robot)), plan.events[0]
    speeds = np.abs(plan.trajectory.velocities[:, 0])
    fastest = float(plan.trajectory.times[int(np.argmax(speeds))])
    for t in fastest + np.linspace(-0.004, 0.004, 17):
        here, there = (plan.trajectory.sample(float(at))[0] for at in (t, t + late))
        fired = measure(replace(event, t_trigger=float(t + late)), here, fastest + 0.03)
        assert fired == pytest.approx(abs(float(here[0] - there[0])), abs=2e-5)
