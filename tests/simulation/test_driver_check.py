"""The conformance test of drivers: the simulated world and the recorder pass, every fault is named."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.tool import ToolState
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.simulation import driver_check
from pickcli.simulation.driver_check import DriverReport, check_driver
from pickcli.simulation.planned_contacts import PlannedContacts
from pickcli.simulation.recorder import Recorder
from pickcli.simulation.world import World
from support.pedestal import BuildWorld, evacuate
from support.rail_pick import GAP, rail_pick
from support.tool_states import STRAIGHT


@pytest.fixture
def plan(cell: Cell) -> Plan:
    return rail_pick(cell)


@pytest.fixture
def world(build_world: BuildWorld) -> Iterator[World]:
    """The item 40 mm in front of the cup, the line evacuated."""
    world = build_world(None, gap=GAP, tool_state=STRAIGHT)
    world.planned = PlannedContacts()
    evacuate(world)
    yield world


def faults(report: DriverReport) -> dict[str, str]:
    return {check.what: check.fault for check in report.checks if check.fault}


def test_the_simulated_world_keeps_to_the_protocol(world: World, plan: Plan) -> None:
    report = check_driver(world, plan)
    assert faults(report) == {} and report.is_passed
    assert report.record is not None
    assert [fired.event for fired in report.record.events] == list(plan.events)


def recorder(cell: Cell, plan: Plan, kind: type[Recorder] = Recorder, **more: Any) -> Recorder:
    return kind(cell, plan.trajectory.positions[0], STRAIGHT, **more)


@pytest.mark.parametrize("time_step", [1e-3, 4e-3, 8e-3])
def test_a_recorder_keeps_to_the_protocol(cell: Cell, plan: Plan, time_step: float) -> None:
    report = check_driver(recorder(cell, plan, time_step=time_step), plan)
    assert faults(report) == {} and report.is_passed


class Rare(Recorder):
    """Takes a set point every second."""

    def __init__(self, cell: Cell, q: Array, tool_state: ToolState) -> None:
        super().__init__(cell, q, tool_state, 1.0)


class Short(Recorder):
    """Forgets a joint."""

    @property
    def q(self) -> Array:
        return super().q[:-1]


class Lost(Recorder):
    """Does not know where it stands."""

    @property
    def q(self) -> Array:
        return super().q * np.nan


class Beyond(Recorder):
    """Counts in degrees."""

    @property
    def q(self) -> Array:
        return np.rad2deg(super().q)


class Elsewhere(Recorder):
    """Stands beside the first point."""

    @property
    def q(self) -> Array:
        return super().q + 0.02


class Willing(Recorder):
    """Takes any device."""

    def act(self, device: str, action: str) -> bool | None:
        return super().act(device, action) if device in self.cell.devices else None


class WillingOfActions(Recorder):
    """Takes any action."""

    def act(self, device: str, action: str) -> bool | None:
        known = device not in self.cell.devices or action in self.cell.devices[device].actions
        return super().act(device, action) if known else None


class Mute(Recorder):
    """Has sensors that say nothing."""

    def act(self, device: str, action: str) -> bool | None:
        return super().act(device, action) and None


class Creeping(Recorder):
    """Drifts away."""

    def step(self) -> None:
        super().step()
        self._q = self._q + 1e-4 * self.t / self.time_step


class Changing(Recorder):
    """Writes every measurement into one array."""

    def step(self) -> None:
        before = self._q
        super().step()
        before[:] = self._q + 1e-5
        self._q = before


class Frozen(Recorder):
    """Has a clock that stands."""

    @property
    def t(self) -> float:
        return 3.0


class Slow(Recorder):
    """Takes twice the time it says."""

    @property
    def t(self) -> float:
        return 2.0 * super().t


class Keeping(Recorder):
    """Keeps the array of its set point instead of its content."""

    def command(self, q: Array) -> None:
        self._command = q

    def step(self) -> None:
        super().step()
        self._q = np.array(self._q)


class Deaf(Recorder):
    """Does not move."""

    def command(self, q: Array) -> None:
        pass


class Hurried(Recorder):
    """Has a clock that goes too fast once it moves."""

    @property
    def t(self) -> float:
        return super().t + max(0.0, super().t - 0.5)


class Sagging(Recorder):
    """Sinks when it has arrived."""

    n_at_rest = 0

    def step(self) -> None:
        is_at_rest = np.array_equal(self._command, self.target)
        self.n_at_rest += is_at_rest
        super().step()
        if self.n_at_rest > 50:
            self._q = self._q + 0.02

    def __init__(self, cell: Cell, q: Array, *more: Any) -> None:
        super().__init__(cell, q, *more)
        self.target = rail_pick(cell).trajectory.positions[-1]


class Breaking(Recorder):
    """Loses its connection under way."""

    def step(self) -> None:
        if self.t > 1.0:
            raise ConnectionError("no answer")
        super().step()


class Empty(Recorder):
    """Holds nothing."""

    def act(self, device: str, action: str) -> bool | None:
        return None if super().act(device, action) is None else False


class Talkative(Recorder):
    """Answers for its valve."""

    def act(self, device: str, action: str) -> bool | None:
        return super().act(device, action) or device == "valve" or None


class Once(Recorder):
    """Is closed only once."""

    def close(self) -> None:
        if not hasattr(self, "_open"):
            self._open = False
            return
        raise RuntimeError("closed already")


class SetBack(Recorder):
    """Has a clock that is set back once, by less than a tenth of the time it has run."""

    at_step, n_steps = 50, 0

    def step(self) -> None:
        super().step()
        self.n_steps += 1

    @property
    def t(self) -> float:
        return super().t - 0.004 * (self.n_steps >= self.at_step)


class SetBackUnderWay(SetBack):
    """The same, once it moves."""

    at_step = 600


FAULTY: list[tuple[type[Recorder], str, str]] = [
    (Rare, "its period is that of a stream", "time_step is 1.0"),
    (Short, "it measures a configuration of the cell", "q is no array of 8 floats"),
    (Lost, "it measures a configuration of the cell", "q is not finite"),
    (Beyond, "it measures a configuration of the cell", "is beyond its limits"),
    (Elsewhere, "it stands at the start of the plan", "refusing to start"),
    (Willing, "it refuses devices and actions that the cell does not have", "'no such name', 'on'"),
    (
        WillingOfActions,
        "it refuses devices and actions that the cell does not have",
        "'pump', 'no such name'",
    ),
    (Mute, "its sensors answer yes or no", "vacuum_sensor answers None"),
    (Creeping, "it stands when commanded to", "while commanded to stand"),
    (Changing, "it stands when commanded to", "changed afterwards"),
    (Frozen, "its clock runs with its steps", "after a step"),
    (SetBack, "its clock runs with its steps", "after a step"),
    (Slow, "its clock runs with its steps", "a step takes 0.00200 s on average"),
    (Keeping, "it executes the plan and arrives", "keeps the array of its set point"),
    (Deaf, "it executes the plan and arrives", "following error"),
    (Breaking, "it executes the plan and arrives", "ConnectionError: no answer"),
    (Sagging, "it executes the plan and arrives", "rail ends 0.0200 from the plan's last point"),
    (SetBackUnderWay, "its clock runs with its steps while it moves", "after a step"),
    (Hurried, "its clock runs with its steps while it moves", "a step takes"),
    (Empty, "it executes the plan and arrives", "nothing is held"),
    (Talkative, "its devices answer as the protocol says", "valve answers True"),
    (Once, "it is closed, also twice", "RuntimeError: closed already"),
]


@pytest.mark.parametrize(("kind", "what", "told"), FAULTY, ids=[kind.__name__ for kind, _, _ in FAULTY])
def test_every_fault_is_named(cell: Cell, plan: Plan, kind: type[Recorder], what: str, told: str) -> None:
    report = check_driver(recorder(cell, plan, kind), plan)
    found = faults(report)
    assert list(found) == [what] and told in found[what]
    assert not report.is_passed
    failed = [check.what for check in report.checks].index(what)
    untried = [check.is_tried for check in report.checks[failed + 1 : -1]]
    assert not any(untried)


@pytest.mark.parametrize("kind", [kind for kind, _, _ in FAULTY[:13]])
def test_nothing_moves_after_a_fault(cell: Cell, plan: Plan, kind: type[Recorder]) -> None:
    driver = recorder(cell, plan, kind)
    check_driver(driver, plan)
    sent = np.array([q for _, q in driver.set_points]).reshape(-1, 8)
    assert np.all(np.abs(sent - plan.trajectory.positions[0]) < 0.03)
    assert {device for _, device, _ in driver.actions} <= {"vacuum_sensor"}


def test_events_that_come_elsewhere_are_named(
    cell: Cell, plan: Plan, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(driver_check, "EVENT_TOLERANCE", -1.0)
    found = faults(check_driver(recorder(cell, plan), plan))
    assert list(found) == ["its measurements let events fire in their places"]
    assert "valve on came" in found["its measurements let events fire in their places"]
