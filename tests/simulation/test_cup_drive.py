"""The simulated actuator of the cup reaches the commanded position in its time, from rest to rest."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pickcli.simulation.servo import CupDrive

STEP = 1e-3  # s
WAY, DURATION = 1.5, 0.3  # rad and s


def driven(drive: CupDrive, position: float, n: int) -> np.ndarray:
    """Positions (n,) of a joint that does as it is told, after each step."""
    out = []
    for _ in range(n):
        position += float(drive.velocities(np.array([position]), STEP)[0]) * STEP
        out.append(position)
    return np.array(out)


@given(start=st.floats(0.0, WAY), goal=st.floats(0.0, WAY))
def test_it_arrives_in_its_time_and_never_turns_back(start: float, goal: float) -> None:
    drive = CupDrive(start, DURATION, 20.0, 0.0)
    drive.command(goal)
    n = int(np.ceil(DURATION / STEP))
    found = driven(drive, start, n + 1)
    assert abs(found[-1] - goal) < 1e-9
    steps = np.diff(np.append(start, found))
    assert (steps * np.sign(goal - start) > -1e-12).all()


def test_it_starts_and_ends_at_rest() -> None:
    drive = CupDrive(0.0, DURATION, 20.0, 0.0)
    drive.command(WAY)
    speeds = np.diff(driven(drive, 0.0, 300)) / STEP
    assert speeds[[0, -1]].max() < 0.01 < 9.0 < speeds.max() < 2.0 * WAY / DURATION


def test_a_new_command_on_the_way_leads_on_from_there() -> None:
    drive = CupDrive(0.0, DURATION, 20.0, 0.0)
    drive.command(WAY)
    there = driven(drive, 0.0, 150)[-1]
    assert abs(there - WAY / 2) < 0.01
    drive.command(0.0)
    back = driven(drive, there, 301)
    assert back[0] < there and abs(back[-1]) < 1e-9
