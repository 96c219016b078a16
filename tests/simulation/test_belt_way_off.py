"""The way off a running belt: at every instant, whatever the belt does, within limits and along the lines."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.geometry import Array
from pickcli.simulation.belt_clock import BeltClock
from pickcli.simulation.belt_way_off import BeltWayOff
from pickcli.simulation.stream import Stream, violations
from support.belt_picks import belt_pick, cell

STEP, SPEED, LATENCY, COUNT = 1e-3, 0.33, 0.004, 1e-5
Travel = Callable[[float], float]


@dataclass
class FakeEncoder:
    """A belt by its travel over time, read in counts and late."""

    travel: Travel
    t: float = 0.0

    def belt_travel(self, conveyor: str) -> float | None:
        return COUNT * round(self.travel(self.t - LATENCY) / COUNT)

    def encoder_latency(self, conveyor: str) -> float:
        return LATENCY


def to_speed(speed: float, t_change: float) -> Travel:
    """Travel of a belt that comes to another speed at 0.5 m/s^2."""

    def travel(t: float) -> float:
        since = max(0.0, t - t_change)
        changing = min(since, abs(speed - SPEED) / 0.5)
        more = np.sign(speed - SPEED) * 0.25 * changing**2 + (speed - SPEED) * (since - changing)
        return SPEED * t + float(more)

    return travel


def begun(travel: Travel, into: float) -> tuple[FakeEncoder, BeltClock, list[Array], list[float]]:
    """A pick until some s after the axis has come up to the belt's speed, or until the belt strays."""
    plan, encoder = belt_pick().plan, FakeEncoder(travel)
    clock = BeltClock(plan, cell(), encoder, STEP)
    points, times = [], [0.0]
    while times[-1] < clock.t_works + into and not clock.is_off:
        encoder.t += STEP
        times.append(clock.next())
        points.append(plan.trajectory.sample(times[-1])[0])
    return encoder, clock, points, times[1:]


def left(
    encoder: FakeEncoder,
    clock: BeltClock,
    points: list[Array],
    times: list[float],
    is_back: bool,
    of: Cell | None = None,
) -> tuple[BeltWayOff, float]:
    """The way off from there, and the most m that the arm was off the belt on its lines."""
    off, most = BeltWayOff(belt_pick().plan, of or cell(), clock, STEP, is_back), 0.0
    while not off.is_at_rest and len(points) < 30_000:
        encoder.t += STEP
        points.append(off.next())
        times.append(off.t)
        relative = points[-1][0] - belt_pick().plan.trajectory.sample(off.t)[0][0]
        if not off.is_clear:
            most = max(most, abs(encoder.travel(encoder.t) - SPEED * off.t - relative))
    assert off.is_at_rest
    return off, most


def assert_within_limits(points: list[Array], times: list[float]) -> None:
    robot = cell().robot
    commands = Stream(np.array(times), np.array(points))
    assert violations(commands, robot.joint_names, robot.limits, STEP, cell().speed_scale) == ()


@pytest.mark.parametrize("into", [0.002, 0.04, 0.12, 0.27, 0.47])
def test_back_from_every_instant_before_the_item_is_met(into: float) -> None:
    encoder, clock, points, times = begun(lambda t: SPEED * t, into)
    off, most = left(encoder, clock, points, times, is_back=True)
    assert off.is_clear and off.t == pytest.approx(clock.t_works, abs=1e-9) and most < 2e-3
    ready = belt_pick().plan.trajectory.sample(clock.t_works)[0]
    assert points[-1][1:] == pytest.approx(ready[1:], abs=1e-9)
    assert_within_limits(points, times)


@pytest.mark.parametrize("into", [0.37, 0.67, 0.97])
@pytest.mark.parametrize("speed", [0.5, 0.1])
def test_on_from_every_instant_after_that_with_a_belt_that_changes_its_speed_meanwhile(
    into: float, speed: float
) -> None:
    clock = begun(lambda t: SPEED * t, 0.01)[1]
    encoder, clock, points, times = begun(to_speed(speed, clock.t_works + into), into)
    off, most = left(encoder, clock, points, times, is_back=False)
    assert off.is_clear and off.t == pytest.approx(clock.t_left, abs=1e-9) and most < 0.015
    assert_within_limits(points, times)


@pytest.mark.parametrize("into", [0.07, 0.27, 0.57, 0.87])
def test_a_belt_that_runs_away_is_left_within_what_is_proven(into: float) -> None:
    clock = begun(lambda t: SPEED * t, 0.01)[1]
    encoder, clock, points, times = begun(to_speed(0.5, clock.t_works + into), 5.0)
    assert clock.is_off and clock.t_works < times[-1] < clock.t_left
    off, most = left(encoder, clock, points, times, is_back=into < 0.17)
    assert off.is_clear and 2e-3 < most < 0.015
    assert_within_limits(points, times)


def test_a_belt_that_stands_is_left_as_well() -> None:
    """The plan's own time stands with it; the lines are gone back in the time of the controller."""
    clock = begun(lambda t: SPEED * t, 0.01)[1]
    encoder, clock, points, times = begun(to_speed(0.0, clock.t_works + 0.1), 0.40)
    off, _ = left(encoder, clock, points, times, is_back=True)
    assert off.is_clear
    assert_within_limits(points, times)


@pytest.mark.parametrize("into", [0.17, 0.37, 0.57])
@pytest.mark.parametrize("ahead", [0.10, 0.14, 0.20])
def test_near_the_end_of_its_axis_the_arm_goes_on_along_its_lines(into: float, ahead: float) -> None:
    """The axis comes to rest before its end, the lines do not stop with it, and all limits hold."""
    encoder, clock, points, times = begun(lambda t: SPEED * t, into)
    robot = cell().robot
    upper = robot.limits.upper.copy()
    upper[0] = points[-1][0] + ahead
    short = replace(cell(), robot=replace(robot, limits=replace(robot.limits, upper=upper)))
    off, _ = left(encoder, clock, points, times, is_back=False, of=short)
    assert off.is_clear and off.t == pytest.approx(clock.t_left, abs=1e-9)
    assert_within_limits(points, times)
    assert max(q[0] for q in points) <= upper[0] + 1e-3


@pytest.mark.parametrize("more", [1, 60, 200])
def test_a_way_on_along_the_lines_can_be_turned_back(more: int) -> None:
    """As soon as it has begun, and at speed; it ends where the lines begin, within all limits."""
    encoder, clock, points, times = begun(lambda t: SPEED * t, 0.5)
    off = BeltWayOff(belt_pick().plan, cell(), clock, STEP, is_back=False)
    for k in range(30_000):
        if k == more:
            off.turn_back()
        encoder.t += STEP
        points.append(off.next())
        times.append(off.t)
        if off.is_at_rest:
            break
    assert off.is_clear and off.t == pytest.approx(clock.t_works, abs=1e-9)
    assert_within_limits(points, times)
