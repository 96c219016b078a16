"""Stopping distances against a simulation in small steps, and known answers."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.watching.stopping_distance import stopping_distance, stopping_time, travel_while_stopping

SPEEDS, DELAYS, DECELERATIONS = st.floats(0.0, 3.0), st.floats(0.0, 1.0), st.floats(0.2, 4.0)
STEP = 1e-3  # s


def integrated(speed: float, delay: float, deceleration: float, until: float) -> float:
    """M of travel, summed over steps: full speed in the delay, then less in each step."""
    travel, time, now = 0.0, 0.0, speed
    while now > 0 and time < until:
        after = now if time < delay else max(0.0, now - deceleration * STEP)
        travel += (now + after) / 2 * STEP
        time, now = time + STEP, after
    return travel


def test_stopping_distance_of_known_figures() -> None:
    assert stopping_distance(1.0, 0.2, 1.0) == pytest.approx(0.7)
    assert stopping_distance(2.0, 0.0, 0.5) == pytest.approx(4.0)
    assert stopping_distance(0.0, 5.0, 1.0) == 0.0
    assert stopping_time(1.0, 0.2, 0.5) == pytest.approx(2.2)


@given(SPEEDS, DELAYS, DECELERATIONS)
def test_stopping_distance_is_that_of_a_simulation(speed: float, delay: float, deceleration: float) -> None:
    summed = integrated(speed, delay, deceleration, 1e9)
    assert stopping_distance(speed, delay, deceleration) == pytest.approx(summed, abs=2 * STEP * (speed + 1))


@given(SPEEDS, DELAYS, DECELERATIONS, st.floats(0.0, 1.0))
def test_travel_while_stopping_is_that_of_a_simulation(
    speed: float, delay: float, deceleration: float, share: float
) -> None:
    time = share * stopping_time(speed, delay, deceleration)
    summed = integrated(speed, delay, deceleration, time)
    found = travel_while_stopping(speed, delay, deceleration, time)
    assert found == pytest.approx(summed, abs=2 * STEP * (speed + 1))
    rest = travel_while_stopping(speed, delay, deceleration, 100.0)
    assert rest == pytest.approx(stopping_distance(speed, delay, deceleration))
