"""URScript: what the program does when it runs, by an interpreter of the few lines that it is made of."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from pickcli.cell.device import Device, DeviceKind
from pickcli.errors import InputError, UnknownNameError
from pickcli.export.channels import Channel, channels
from pickcli.export.exporter import ExportRequest
from pickcli.export.urscript import EXPORTER, SETTLE
from pickcli.geometry import Array
from support.exported_motions import handmade_pick, ur_request

NUMBER = r"(-?\d+(?:\.\d+)?)"


@dataclass
class Controller:
    """What a controller does with the program.

    Attributes:
        inputs: Digital inputs that are on.
        q: Where the arm stands.
        t: s since the program moves.
        points: Set points with the times at which they are due.
        outputs: (t, number, whether on) of every switch.
        messages: What is shown.
    """

    inputs: frozenset[int]
    q: Array
    t: float = 0.0
    points: list[tuple[float, Array]] = field(default_factory=list)
    outputs: list[tuple[float, int, bool]] = field(default_factory=list)
    messages: list[str] = field(default_factory=list)
    has_halted: bool = False
    has_stopped: bool = False

    def run(self, program: str) -> Controller:
        lines = [line for line in program.splitlines() if not line.startswith("#")]
        assert lines[0] == "def apc_plan():" and lines[-2:] == ["end", "apc_plan()"]
        body = [line[2:] for line in lines[1:-2]]
        first = np.fromstring(body[0].partition("[")[2][:-1], sep=",")
        start = body.index("end") + 1
        check = "\n".join(body[:start])
        assert f"if norm(here[k] - first[k]) > {0.01}:" in check and "while k < 6:" in check
        if np.abs(self.q - first).max() > 0.01:
            self._end(check)
            return self
        k = start
        while k < len(body) and not self.has_halted:
            k = self._step(body, k)
        return self

    def _step(self, body: list[str], k: int) -> int:
        line = body[k]
        if found := re.fullmatch(rf"servoj\(\[(.*)\], t={NUMBER}, lookahead_time=0.03, gain=300\)", line):
            self.t += float(found[2])
            self.q = np.fromstring(found[1], sep=",")
            self.points.append((self.t, self.q))
        elif found := re.fullmatch(r"set_standard_digital_out\((\d), (True|False)\)", line):
            self.outputs.append((self.t, int(found[1]), found[2] == "True"))
        elif found := re.fullmatch(r"if not get_standard_digital_in\((\d)\):", line):
            end = body.index("end", k)
            if int(found[1]) not in self.inputs:
                self._end("\n".join(body[k:end]))
            return end + 1
        else:
            assert line == "stopj(2)" and k == len(body) - 1, line
            self.has_stopped = True
        return k + 1

    def _end(self, lines: str) -> None:
        found = re.search(r'popup\("(.*)", "apc", error=True, blocking=True\)', lines)
        assert found is not None and "halt" in lines
        self.messages.append(found[1])
        self.has_halted = True


def run(request: ExportRequest, inputs: tuple[int, ...] = (0,), away: float = 0.0) -> Controller:
    program = EXPORTER.encode(request).decode("ascii")
    return Controller(frozenset(inputs), request.plan.trajectory.positions[0] + away).run(program)


@pytest.mark.parametrize("rate", [None, 125.0, 250.0, 500.0])
def test_the_arm_is_sent_along_the_plan_and_held_at_its_end(rate: float | None) -> None:
    request = ur_request(rate)
    trajectory, done = request.plan.trajectory, run(request)
    times = np.array([t for t, _ in done.points])
    sent = np.array([q for _, q in done.points])
    np.testing.assert_allclose(np.diff(times), 1.0 / (rate or 125.0), atol=1e-12)
    is_before = times < trajectory.duration
    expected = trajectory.sample(times[is_before])
    np.testing.assert_allclose(sent[is_before], expected, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(
        sent[~is_before], np.tile(trajectory.positions[-1], (sum(~is_before), 1)), atol=1e-9
    )
    assert times[-1] >= trajectory.duration + SETTLE - 0.008
    limits = request.scene.cell.robot.limits
    assert np.all(sent >= limits.lower) and np.all(sent <= limits.upper)
    assert done.has_stopped and not done.has_halted


@pytest.mark.parametrize("rate", [125.0, 500.0])
def test_outputs_switch_at_the_events_within_half_a_period(rate: float) -> None:
    request = ur_request(rate)
    done = run(request)
    wired = {"pump": 0, "valve": 1}
    planned = sorted(
        (e.t_trigger or 0.0, wired[e.device], e.action == "on")
        for e in request.plan.events
        if e.device in wired
    )
    assert [each[1:] for each in done.outputs] == [each[1:] for each in planned]
    apart = [abs(one[0] - other[0]) for one, other in zip(done.outputs, planned, strict=True)]
    assert max(apart) <= 0.5 / rate + 1e-9


def test_a_sensor_that_says_no_ends_the_program() -> None:
    done = run(ur_request(), inputs=())
    assert done.messages == ["vacuum_sensor: nothing is held."] and done.has_halted
    assert abs(done.t - 1.0) <= 0.004 and not done.has_stopped


@pytest.mark.parametrize("away", [0.011, -0.02])
def test_an_arm_that_stands_elsewhere_is_not_moved(away: float) -> None:
    done = run(ur_request(), away=away)
    assert done.messages == ["The arm does not stand at the first point of the plan."]
    assert done.points == [] and done.outputs == []


def test_an_arm_that_stands_nearly_there_is_moved() -> None:
    assert run(ur_request(), away=0.009).has_stopped


def test_channels_are_told_and_chosen() -> None:
    text = EXPORTER.encode(ur_request(valve=3)).decode()
    assert "# digital output 3: valve, on for on\n" in text and "# digital output 0: pump" in text
    assert "# digital input 0: vacuum_sensor, on where something is held\n" in text
    assert {number for _, number, _ in run(ur_request(valve=3)).outputs} == {0, 3}


def test_no_text_from_outside_ends_a_line() -> None:
    request = ur_request()
    odd = replace(request.plan, query='pick "x"\nhalt \u2026')
    text = EXPORTER.encode(replace(request, plan=odd)).decode("ascii")
    assert text.splitlines()[0] == "# Written by apc export: pick ?x??halt ?"


@pytest.mark.parametrize("rate", [100.0, 1e9, 0.0, -125.0])
def test_rates_of_no_controller_are_refused(rate: float) -> None:
    with pytest.raises(InputError, match="is no rate of these controllers; name 125, 250 or 500"):
        EXPORTER.encode(ur_request(rate))


def test_other_arms_are_refused() -> None:
    with pytest.raises(InputError, match="URScript is for the six joints of Universal Robots"):
        EXPORTER.encode(handmade_pick())


def test_the_same_plan_gives_the_same_bytes() -> None:
    assert EXPORTER.encode(ur_request()) == EXPORTER.encode(ur_request())


def device(name: str, kind: DeviceKind, *actions: str) -> Device:
    return Device(name, kind, 0.1, actions)


def test_devices_take_what_is_free_in_the_order_of_the_cell() -> None:
    devices = {
        each.name: each
        for each in (
            device("pump", DeviceKind.PUMP, "on", "off"),
            device("gauge", DeviceKind.SENSOR, "read"),
            device("hand", DeviceKind.GRIPPER, "open", "closed"),
            device("valve", DeviceKind.VALVE, "off", "on"),
        )
    }
    assert channels(devices, {"hand": 0, "gauge": 5}) == {
        "pump": Channel(1, False, "on"),
        "gauge": Channel(5, True, "read"),
        "hand": Channel(0, False, "closed"),
        "valve": Channel(2, False, "on"),
    }
    assert list(channels(devices, {})) == ["pump", "gauge", "hand", "valve"]


@pytest.mark.parametrize(
    ("chosen", "told"),
    [
        ({"valve": 8}, "expected 0 to 7"),
        ({"valve": 2, "pump": 2}, "has that output"),
        ({"valv": 2}, "did you mean 'valve'"),
    ],
)
def test_channels_that_cannot_be_are_refused(chosen: dict[str, int], told: str) -> None:
    with pytest.raises(InputError, match=told):
        channels(ur_request().scene.cell.devices, chosen)


def test_unknown_devices_are_unknown_names() -> None:
    with pytest.raises(UnknownNameError):
        channels({}, {"valve": 1})


def test_more_devices_than_outputs_and_more_actions_than_two_are_refused() -> None:
    many = {f"v{k}": device(f"v{k}", DeviceKind.VALVE, "on", "off") for k in range(9)}
    with pytest.raises(InputError, match="device v8: no output is left for it, there are 8"):
        channels(many, {})
    with pytest.raises(InputError, match="has 3 actions, and one digital output tells two apart"):
        channels({"hand": device("hand", DeviceKind.GRIPPER, "open", "half", "closed")}, {})
