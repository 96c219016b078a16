"""The operator stops the robot at any time: it rests on its path, keeps its item, and goes on to the end."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.cell import Cell
from pickcli.simulation.drive import drive
from pickcli.simulation.execute import execute
from pickcli.simulation.operator_stop import OperatorStop, signal_of
from pickcli.simulation.plan_run import END_TIME, HARDER, LEAST_STOP
from pickcli.simulation.planned_contacts import PlannedContacts
from pickcli.simulation.recorder import Recorder
from pickcli.timing.stopping_trajectory import resume, stop
from support.handmade_plans import cell as shipped_cell
from support.handmade_plans import pick
from support.pedestal import BuildWorld, evacuate
from support.rail_pick import GAP, rail_pick
from support.tool_states import STRAIGHT

PLAN = pick()[0]
DURATION = PLAN.trajectory.duration


@given(begin=st.floats(0.0, DURATION), wait=st.floats(0.0, 2.0))
@settings(max_examples=40, deadline=None)
def test_stopped_at_any_time_it_keeps_path_limits_and_events(begin: float, wait: float) -> None:
    driver = Recorder(shipped_cell(), PLAN.trajectory.positions[0], PLAN.segments[0].tool_state)
    record = drive(PLAN, driver, operator=signal_of([OperatorStop(begin, begin + wait)]))
    assert record.is_clean, record.trouble
    fired = [f.event for f in record.events]
    assert fired == list(PLAN.events)
    assert max(f.distance for f in record.events) < 2e-3
    points = np.array([q for _, q in driver.set_points])
    path = PLAN.trajectory.sample(np.linspace(0.0, DURATION, 6000))
    assert max(float(np.abs(path - q).max(axis=1).min()) for q in points[::20]) < 2e-3
    np.testing.assert_allclose(points[-1], PLAN.trajectory.positions[-1], atol=1e-9)
    assert record.duration >= DURATION + END_TIME - 2e-3
    for held in record.operator_stops:
        assert held.end is not None
        standing = [q for t, q in driver.set_points if held.end - 5e-3 < t <= held.end]
        if wait > 1.0:
            assert np.ptp(np.array(standing), axis=0).max() < 1e-6


@pytest.mark.parametrize("share", np.linspace(0.02, 0.97, 12))
def test_the_times_on_the_plan_are_those_of_the_points(share: float) -> None:
    limits, at = shipped_cell().robot.limits, share * DURATION
    halted = stop(PLAN.trajectory, at, limits)
    resumed = resume(PLAN.trajectory, halted.path_time, limits)
    for part in (halted, resumed):
        t = np.linspace(0.0, part.trajectory.duration, 800)
        on_plan = PLAN.trajectory.sample(part.path_times(t))
        np.testing.assert_allclose(part.trajectory.sample(t), on_plan, atol=2e-6)
        assert (np.diff(part.path_times(t)) >= -1e-12).all()
    assert halted.path_times(np.array([halted.trajectory.duration]))[0] == pytest.approx(halted.path_time)
    assert resumed.path_times(np.array([0.0]))[0] == pytest.approx(halted.path_time)


@pytest.mark.parametrize("begin", [0.3, 0.9, 1.4, 2.2])
def test_an_item_in_the_cup_is_held_through_the_stop_and_released_at_its_place(
    cell: Cell, build_world: BuildWorld, begin: float
) -> None:
    world = build_world(gap=GAP, tool_state=STRAIGHT)
    world.planned = PlannedContacts()
    evacuate(world)
    operator = signal_of([OperatorStop(begin, begin + 3.0)], world.t)
    record = execute(rail_pick(cell), world, operator=operator)
    assert record.is_clean, record.trouble
    assert len(record.operator_stops) == 1
    (stopped,) = record.operator_stops
    assert stopped.begin == pytest.approx(begin, abs=2e-3) and stopped.end == pytest.approx(
        begin + 3.0, abs=2e-3
    )
    assert record.has_item and [r.is_wanted for r in record.releases] == [True]
    assert record.collisions == ()


@given(share=st.floats(0.0, 1.0))
@settings(max_examples=40, deadline=None)
def test_with_an_item_stop_and_resume_accelerate_no_harder_than_the_plan(share: float) -> None:
    """What the tool bears was judged for the plan: at the limits of the joints an item may be torn off."""
    held = [segment for segment in PLAN.segments if segment.held is not None]
    begin = held[0].t_start + share * (held[-1].t_end - held[0].t_start)
    driver = Recorder(shipped_cell(), PLAN.trajectory.positions[0], PLAN.segments[0].tool_state)
    record = drive(PLAN, driver, operator=signal_of([OperatorStop(begin, begin + 2.0)]))
    assert record.is_clean, record.trouble
    times = np.arange(held[0].t_start, held[-1].t_end, driver.time_step)
    limits = driver.cell.robot.limits.acceleration
    most = np.maximum(np.abs(PLAN.trajectory.sample(times, 2)).max(axis=0), LEAST_STOP * limits)
    points = np.array([q for t, q in driver.set_points if begin - 0.01 < t < begin + 3.0])
    used = np.abs(np.diff(points, 2, axis=0)).max(axis=0) / driver.time_step**2
    assert (used <= 1.02 * HARDER * most + 1e-3).all()


@given(
    begin=st.floats(0.0, DURATION),
    times=st.lists(st.floats(0.001, 0.6), min_size=3, max_size=7),
)
@settings(max_examples=40, deadline=None)
def test_a_bouncing_button_breaks_no_limit(begin: float, times: list[float]) -> None:
    """Stops that follow each other while the robot still brakes, or comes up to speed again."""
    edges = np.cumsum([begin, *times])
    stops = [OperatorStop(a, b) for a, b in zip(edges[::2], edges[1::2], strict=False)]
    driver = Recorder(shipped_cell(), PLAN.trajectory.positions[0], PLAN.segments[0].tool_state)
    record = drive(PLAN, driver, operator=signal_of(stops))
    assert record.is_clean, record.trouble
    assert [f.event for f in record.events] == list(PLAN.events)
    np.testing.assert_allclose(driver.set_points[-1][1], PLAN.trajectory.positions[-1], atol=1e-9)


class Denying(Recorder):
    """Its sensor reads that nothing is held."""

    def act(self, device: str, action: str) -> bool | None:
        answer = super().act(device, action)
        return None if answer is None or action != "read" else self.n_reads() <= 1

    def n_reads(self) -> int:
        """How often the sensor was read."""
        return sum(action == "read" for _, _, action in self.actions)


@given(before=st.floats(-0.2, 0.6))
@settings(max_examples=30, deadline=None)
def test_a_protective_stop_within_that_of_the_operator_breaks_no_limit(before: float) -> None:
    read = next(event for event in PLAN.events if event.action == "read")
    begin = max(0.0, (read.t_trigger or 0.0) - before)
    driver = Denying(shipped_cell(), PLAN.trajectory.positions[0], PLAN.segments[0].tool_state)
    record = drive(PLAN, driver, operator=signal_of([OperatorStop(begin, begin + 0.3)]))
    assert record.limit_violations == ()
    if record.stop is not None:
        assert record.path_time is not None
        end = PLAN.trajectory.sample(record.path_time)[0]
        np.testing.assert_allclose(driver.set_points[-1][1], end, atol=1e-6)
        assert all(held.end is None or held.end < record.duration for held in record.operator_stops)


def test_stopped_twice_it_goes_on_twice(cell: Cell) -> None:
    plan = rail_pick(cell)
    driver = Recorder(cell, plan.trajectory.positions[0], plan.segments[0].tool_state)
    operator = signal_of([OperatorStop(0.5, 1.0), OperatorStop(1.6, 1.7)])
    record = drive(plan, driver, operator=operator)
    assert record.is_clean and len(record.operator_stops) == 2


def test_a_robot_that_is_never_stopped_has_no_such_record(cell: Cell) -> None:
    plan = rail_pick(cell)
    driver = Recorder(cell, plan.trajectory.positions[0], plan.segments[0].tool_state)
    assert drive(plan, driver).operator_stops == ()
