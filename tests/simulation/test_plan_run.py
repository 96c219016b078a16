"""Plans carried out by any driver: what it is sent, when devices act, when it waits and stops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.tool import MOVING, ToolState
from pickcli.errors import StaleError
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.progress import Progress
from pickcli.simulation.drive import drive
from pickcli.simulation.following import JointFollowing
from pickcli.simulation.plan_run import END_TIME, REST_TOLERANCE, SEAL_TIME
from pickcli.simulation.protective_stop import StopCause
from pickcli.simulation.recorder import Recorder
from pickcli.simulation.start_check import StartError
from pickcli.simulation.thresholds import Thresholds
from support.handmade_plans import pick
from support.rail_pick import T_CONTACT, T_LIFT, T_READ, rail_pick
from support.tool_states import DOWN, STRAIGHT


def recorder(plan: Plan, cell: Cell, kind: type[Recorder] = Recorder) -> Recorder:
    return kind(cell, plan.trajectory.positions[0], plan.segments[0].tool_state)


def test_the_plan_is_sent_every_period_to_its_end(cell: Cell) -> None:
    plan = rail_pick(cell)
    driver = recorder(plan, cell)
    record = drive(plan, driver)
    times = np.array([t for t, _ in driver.set_points])
    expected = plan.trajectory.sample(times)
    np.testing.assert_allclose(np.array([q for _, q in driver.set_points]), expected, atol=1e-9)
    assert record.is_clean and record.max_lag == 0.0
    assert abs(record.duration - plan.trajectory.duration - END_TIME) < 2e-3


def test_devices_act_when_the_plan_says(cell: Cell) -> None:
    plan = rail_pick(cell)
    driver = recorder(plan, cell)
    record = drive(plan, driver)
    assert [(device, action) for _, device, action in driver.actions] == [
        ("valve", "on"), ("vacuum_sensor", "read"), ("valve", "off"),
    ]  # fmt: skip
    for (t, _, _), event in zip(driver.actions, plan.events, strict=True):
        assert abs(t - (event.t_trigger or 0.0)) <= 2.5e-3
    assert [fired.reading for fired in record.events] == [None, True, None] and record.has_item


class Unsealed(Recorder):
    """Its sensor says that nothing is held until a time."""

    t_sealed = np.inf

    def act(self, device: str, action: str) -> bool | None:
        answer = super().act(device, action)
        return None if answer is None else self.t >= self.t_sealed


def test_it_rests_on_the_item_until_the_sensor_says_that_it_is_held(cell: Cell) -> None:
    plan, _ = pick()
    driver = Unsealed(cell, plan.trajectory.positions[0], plan.segments[0].tool_state)
    contact = next(s for s in plan.segments if s.kind == "contact")
    driver.t_sealed = contact.t_end + 0.4
    record = drive(plan, driver)
    assert record.is_clean, record.trouble
    assert abs(record.duration - plan.trajectory.duration - END_TIME - 0.4) < 5e-3
    resting = [q for t, q in driver.set_points if contact.t_end < t < contact.t_end + 0.39]
    assert np.ptp(np.array(resting), axis=0).max() < 1e-9


def test_it_does_not_wait_for_ever_and_stops_where_the_plan_reads_the_sensor(cell: Cell) -> None:
    plan, _ = pick()
    driver = recorder(plan, cell, Unsealed)
    record = drive(plan, driver)
    assert record.stop is not None and record.stop.cause is StopCause.SENSOR
    assert record.has_item is False and record.missed == ()
    read = next(e for e in plan.events if e.action == "read")
    assert abs(record.stop.t - SEAL_TIME - (read.t_trigger or 0.0)) < 0.01
    assert record.path_time is not None
    end = plan.trajectory.sample(record.path_time)[0]
    np.testing.assert_allclose(driver.set_points[-1][1], end, atol=1e-6)
    last = np.array([q for _, q in driver.set_points[-3:]])
    assert np.abs(np.diff(last, axis=0)).max() / driver.time_step < max(REST_TOLERANCE, 1e-4)


class Stuck(Recorder):
    """Stands from a time on."""

    def step(self) -> None:
        before = self._q
        super().step()
        if self.t > 1.5:
            self._q = before


def test_it_stops_where_a_joint_does_not_follow(cell: Cell) -> None:
    plan = rail_pick(cell)
    record = drive(plan, recorder(plan, cell, Stuck))
    assert record.stop is not None and record.stop_cause is StopCause.FOLLOWING_ERROR
    assert record.stop.where == "rail" and record.stop.unit == "m" and 1.5 < record.stop.t < T_READ
    assert "stopped in retreat: following error: rail" in record.trouble
    assert record.path_time is not None and T_LIFT < record.path_time < T_READ
    assert record.stopping_time is not None


def test_a_slow_pace_takes_events_along(cell: Cell) -> None:
    plan = rail_pick(cell)
    driver = recorder(plan, cell)
    record = drive(plan, driver, pace=lambda t: 0.5)
    t_valve = next(t for t, device, _ in driver.actions if device == "valve")
    assert record.is_clean and t_valve > 1.9 * (T_CONTACT - 0.06)
    assert max(fired.distance for fired in record.events) < 1e-3


def test_progress_is_told(cell: Cell) -> None:
    plan, told = rail_pick(cell), list[Progress]()
    drive(plan, recorder(plan, cell), on_progress=told.append)
    assert [round(each.done, 3) for each in told[:3]] == [0.1, 0.2, 0.3] and told[0].what == "contact"


def test_it_does_not_start_elsewhere_nor_in_another_cell(cell: Cell) -> None:
    plan = rail_pick(cell)
    away = Recorder(cell, plan.trajectory.positions[0] + 0.02, STRAIGHT)
    with pytest.raises(StartError):
        drive(plan, away)
    with pytest.raises(StaleError):
        drive(replace(plan, cell_fingerprint="0" * 64), recorder(plan, cell))
    assert away.set_points == []


def test_the_tool_of_a_recorder_takes_the_lead_of_its_device(cell: Cell) -> None:
    driver = Recorder(cell, cell.configurations["home"].q, STRAIGHT)
    driver.act("cup_pivot", "down")
    states: list[ToolState] = []
    n_steps = round(cell.devices["cup_pivot"].lead / 1e-3)
    for _ in range(n_steps + 1):
        states.append(driver.tool_state)
        driver.step()
    assert set(states[: n_steps - 1]) == {MOVING} and driver.tool_state == DOWN


@pytest.mark.parametrize("speed", [0.0, 0.5])
def test_following_allows_for_an_offset_and_a_lag(speed: float) -> None:
    step, q = 1e-3, np.zeros(2)
    watch = JointFollowing(q, step)
    command: Array = q
    for _ in range(500):
        command = command + np.array([speed * step, 0.0])
        watch.remember(command)
    allowed = Thresholds().joint + Thresholds().lag * speed
    assert watch.worst(command - np.array([0.999 * allowed, 0.0])) is None
    off = watch.worst(command - np.array([1.001 * allowed, 0.0]))
    assert off is not None and off[0] == 0 and abs(off[2] - allowed) < 1e-9
