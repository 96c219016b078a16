"""The plan's time by the travel of its belt: steady, slower, stopped, and back to the clock."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from pickcli.simulation.belt_clock import BeltClock
from pickcli.simulation.stream import Stream, violations
from support.belt_picks import BeltPick, belt_pick, cell, pick_on_the_way

STEP, SPEED, LATENCY, COUNT = 1e-3, 0.33, 0.004, 1e-5


@pytest.fixture(params=[belt_pick, pick_on_the_way])
def pick(request: pytest.FixtureRequest) -> BeltPick:
    """One in which the arm rests while the axis comes up to its speed, and one in which it is on its way."""
    made: BeltPick = request.param()
    return made


@dataclass
class FakeEncoder:
    """A belt by its travel over time, read in counts and late."""

    travel: Callable[[float], float]
    t: float = 0.0

    def belt_travel(self, conveyor: str) -> float | None:
        assert conveyor == "belt"
        return COUNT * round(self.travel(self.t - LATENCY) / COUNT)

    def encoder_latency(self, conveyor: str) -> float:
        return LATENCY


def times(
    travel: Callable[[float], float], n: int, pick: BeltPick | None = None
) -> tuple[BeltClock, np.ndarray]:
    """The clock, and the plan's times at n set points."""
    encoder = FakeEncoder(travel)
    clock = BeltClock((pick or belt_pick()).plan, cell(), encoder, STEP)
    found = []
    for k in range(n):
        encoder.t = k * STEP
        found.append(clock.next())
    return clock, np.array(found)


def changing(t_change: float, speed: float, acceleration: float) -> Callable[[float], float]:
    """Travel of a belt that comes to another speed from a time on."""
    lasts = abs(SPEED - speed) / acceleration

    def travel(t: float) -> float:
        since = min(max(t - t_change, 0.0), lasts)
        slowed = np.sign(speed - SPEED) * acceleration * since**2 / 2 + (speed - SPEED) * max(
            0.0, t - t_change - lasts
        )
        return SPEED * t + float(slowed)

    return travel


def test_a_steady_belt_is_a_clock(pick: BeltPick) -> None:
    n = round(pick.plan.trajectory.duration / STEP) - 1
    _, t = times(lambda t: SPEED * t, n, pick)
    assert np.allclose(t, STEP * np.arange(1, n + 1), atol=5e-5)


@pytest.mark.parametrize(
    ("speed", "acceleration", "most"),
    [(0.8 * SPEED, 0.2, 1.5e-3), (1.04 * SPEED, 0.2, 1.5e-3), (0.0, 0.5, 4e-3)],
)
@pytest.mark.parametrize("into", [0.1, 0.6, 1.1])
def test_the_arm_keeps_to_a_belt_that_changes_its_speed(
    pick: BeltPick, speed: float, acceleration: float, most: float, into: float
) -> None:
    start, _ = times(lambda t: SPEED * t, 1, pick)
    travel = changing(start.t_works - 0.3 + into, speed, acceleration)
    clock, t = times(travel, 8000, pick)
    real = STEP * np.arange(1, 8001)
    follows = (t > clock.t_follows) & (t < clock.t_left)
    off = np.array([travel(s) for s in real])[follows] - SPEED * t[follows]
    assert follows.sum() > 100 and np.abs(off).max() < most


@pytest.mark.parametrize(
    ("speed", "acceleration"), [(0.8 * SPEED, 0.2), (0.0, 0.5), (1.03 * SPEED, 0.05), (1.2 * SPEED, 0.2)]
)
@pytest.mark.parametrize("into", [-1.6, -1.0, -0.6, -0.3, 0.1, 0.6, 1.1, 1.9])
def test_whatever_the_belt_does_limits_are_kept_and_what_is_not_proven_is_told(
    pick: BeltPick, speed: float, acceleration: float, into: float
) -> None:
    start, _ = times(lambda t: SPEED * t, 1, pick)
    travel = changing(start.t_works + into, speed, acceleration)
    encoder, trajectory = FakeEncoder(travel), pick.plan.trajectory
    clock, found = BeltClock(pick.plan, cell(), encoder, STEP), [0.0]
    while len(found) < 12_000 and found[-1] < trajectory.duration and not clock.is_off:
        encoder.t += STEP
        found.append(clock.next())
        if clock.t_works < found[-1] < clock.t_left and not clock.is_off:
            assert abs(travel(encoder.t) - SPEED * found[-1]) < clock.allowed + 1e-3
    set_points = Stream(np.array(found), trajectory.sample(np.array(found)))
    robot = cell().robot
    assert violations(set_points, robot.joint_names, robot.limits, STEP, cell().speed_scale) == ()
    assert clock.is_off or found[-1] > clock.t_left or speed == 0.0
    assert not (clock.is_off and 0.8 * SPEED <= speed <= 1.04 * SPEED)


def test_the_plan_comes_in_its_own_time_and_waits_where_it_begins_to_follow() -> None:
    clock, t = times(lambda t: 0.5 * SPEED * t, 8000)
    # Half as fast, the belt takes twice the time.
    comes, follows = (np.flatnonzero(t >= clock.t_follows + later)[0] * STEP for later in (-1e-3, 0.01))
    assert comes == pytest.approx(clock.t_follows, rel=0.02)
    assert follows == pytest.approx(2.0 * clock.t_follows, rel=0.02)
    assert (np.diff(t) >= 0.0).all()


def test_a_belt_that_stops_while_the_arm_comes_costs_only_its_time() -> None:
    clock, _ = times(lambda t: SPEED * t, 1)
    stands = changing(clock.t_follows - 1.0, 0.0, 0.5)

    def travel(t: float) -> float:
        """It stands for two seconds, and runs on."""
        since = max(0.0, t - clock.t_follows - 2.0)
        rising = min(since, SPEED / 0.5)
        return stands(t) + 0.25 * rising**2 + SPEED * (since - rising)

    clock, t = times(travel, 9000)
    following = (t > clock.t_works) & (t < clock.t_left)
    off = np.array([travel(s) for s in STEP * np.arange(1, 9001)])[following] - SPEED * t[following]
    assert following.sum() > 100 and np.abs(off).max() < 6e-3


def test_after_the_item_is_off_the_belt_the_plan_returns_to_the_clock() -> None:
    clock, t = times(changing(0.0, 0.7 * SPEED, 0.2), 12000)
    after = np.flatnonzero((t > clock.t_left) & (t < belt_pick().plan.trajectory.duration))
    rates = np.diff(t[after]) / STEP
    assert rates[0] == pytest.approx(0.7, abs=0.02) and rates[-1] == pytest.approx(1.0)
    assert (np.abs(np.diff(rates)) < 0.01).all()


def test_a_belt_that_has_stopped_holds_the_plan() -> None:
    start, _ = times(lambda t: SPEED * t, 1)
    _, t = times(changing(start.t_follows + 0.5, 0.0, 0.5), 9000)
    assert np.ptp(t[-2000:]) < 1e-4
