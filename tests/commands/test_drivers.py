"""``apc execute --driver`` and ``apc check-driver``: the recorder, and drivers that other packages add."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pickcli.simulation.installed_drivers import GROUP, driver_names
from support.added_package import write_package
from support.command_line import Made, apc, misused, refused

MODULE = """
from pickcli.simulation.recorder import Recorder

class Away(Recorder):
    "Stands 0.2 m beside where the user says."
    @classmethod
    def connect(cls, request):
        q = request.q.copy()
        q[0] += 0.2
        return cls(request.scene.cell, q, request.tool_state)

class Empty(Recorder):
    "Holds nothing."
    def act(self, device, action):
        return None if super().act(device, action) is None else False

def unreachable(request):
    from pickcli.errors import InputError
    raise InputError("192.0.2.1: no answer; switch the controller on")

away, empty, number = Away.connect, Empty.connect, 3

class Faulty(Recorder):
    "Does after 40 steps what one of the drivers below does."
    def step(self):
        super().step()
        if self._n_steps > 40:
            self.fail()
    def fail(self): pass

class Pulled(Faulty):
    def fail(self): raise ConnectionResetError(104, "Connection reset by peer")

class Quits(Faulty):
    def fail(self): raise SystemExit(0)

class Blind(Faulty):
    def fail(self): self._q = self._q * float("nan")

class Shrinks(Faulty):
    def fail(self): self._q = self._q[1:]

class Stands(Faulty):
    def fail(self): self._n_steps = 40

class Breaks(Pulled):
    def close(self): raise RuntimeError("close")

class Silent(Recorder):
    "Its sensors never answer."
    def act(self, device, action):
        super().act(device, action)

class Bare:
    "Has nothing but a cell and a period."
    def __init__(self, request): self.cell, self.time_step = request.scene.cell, 0.004
    t, tool_state = 0.0, None

class Jams(Recorder):
    def close(self): raise RuntimeError("close")

def unknown(request): raise KeyError("controller")
def endless(request): return Recorder(request.scene.cell, request.q, request.tool_state, 0.0)
def hasty(request): return Recorder(request.scene.cell, request.q, request.tool_state, 1e-9)
def lazy(request): return Recorder(request.scene.cell, request.q, request.tool_state, 1e9)

pulled, quits, blind, shrinks = Pulled.connect, Quits.connect, Blind.connect, Shrinks.connect
stands, breaks, jams = Stands.connect, Breaks.connect, Jams.connect
silent, bare = Silent.connect, Bare
"""

FAULTS = {
    "pulled": "ConnectionResetError: [Errno 104] Connection reset by peer",
    "quits": "SystemExit: 0",
    "blind": "q is not finite",
    "shrinks": "q is no array of 8 floats",
    "stands": "t was ",
    "breaks": "ConnectionResetError: [Errno 104] Connection reset by peer",
    "jams": "RuntimeError: close",
    "bare": "AttributeError: 'Bare' object has no attribute 'q'",
    "unknown": "KeyError: 'controller'",
    "endless": "time_step is 0.0, 0.0001 to 0.1 s expected",
    "hasty": "time_step is 1e-09, 0.0001 to 0.1 s expected",
    "lazy": "time_step is 1000000000.0, 0.0001 to 0.1 s expected",
}


@pytest.fixture
def added(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An installed package that adds drivers."""
    folder, module = tmp_path / "site", "added_drivers_of_a_test"
    folder.mkdir()
    names = ("away", "empty", "unreachable", "number", "missing", "silent", *FAULTS)
    write_package(folder, module, MODULE, {GROUP: {name: f"{module}:{name}" for name in names}})
    monkeypatch.syspath_prepend(folder)


def test_a_recorder_plays_a_pick_without_a_world(made: Made) -> None:
    answer = apc("execute", made.plan, "--scene", made.scene, "--driver", "recorder", "--json")
    assert answer.code == 0, answer.err
    told = json.loads(answer.out)
    plan = json.loads(made.plan.read_text())
    assert told["driver"] == "recorder" and told["item_is_in"] is None and told["in_tote"] is None
    events = told["execution"]["events"]
    planned = sorted(plan["events"], key=lambda event: event["t_trigger"])
    assert [(e["device"], e["action"]) for e in events] == [(e["device"], e["action"]) for e in planned]
    assert max(e["distance_m"] for e in events) < 2e-3
    assert told["execution"]["limit_violations"] == [] and "collisions" not in told["execution"]
    text = apc("execute", made.plan, "--scene", made.scene, "--driver", "recorder").out
    assert "tool at most 0.0 mm behind its command" in text and "in the tote" not in text


def test_what_is_of_the_simulated_world_alone_is_refused(made: Made, tmp_path: Path) -> None:
    argv = ("execute", made.move, "--scene", made.scene, "--driver", "recorder")
    misused(apc(*argv, "--video", tmp_path / "film.gif"), "need the simulated world, not driver recorder")
    misused(apc(*argv, "--reality", tmp_path / "reality.json"), "need the simulated world")


def test_an_unknown_driver_comes_with_what_was_meant(made: Made) -> None:
    for argv in (
        ("execute", made.move, "--scene", made.scene, "--driver", "recoder"),
        ("check-driver", "recoder", made.move, "--scene", made.scene),
    ):
        refused(apc(*argv), 3, "unknown driver 'recoder'; did you mean 'recorder'?")


@pytest.mark.parametrize("name", ["recorder", "pybullet"])
def test_drivers_of_the_package_keep_to_the_protocol(name: str, made: Made) -> None:
    answer = apc("check-driver", name, made.move, "--scene", made.scene, "--json")
    assert answer.code == 0, answer.err
    told = json.loads(answer.out)
    assert told["is_passed"] and told["driver"] == name
    assert len(told["checks"]) == 12 and all(check["is_passed"] for check in told["checks"])


@pytest.mark.usefixtures("added")
def test_drivers_of_other_packages_are_listed_and_used(made: Made) -> None:
    names = ("away", "empty", "missing", "number", "silent", "unreachable", *FAULTS)
    assert driver_names() == ["pybullet", "recorder", *sorted(names)]
    argv = ("execute", made.move, "--scene", made.scene, "--driver")
    refused(apc(*argv, "away"), 3, "refusing to start: rail is 0.2000 m", "add --bridge, which does that")
    bridged = apc(*argv, "away", "--bridge", "--json")
    assert bridged.code == 0, bridged.err
    assert json.loads(bridged.out)["bridge"]["stopped"] == ""
    refused(apc(*argv, "unreachable"), 3, "192.0.2.1: no answer; switch the controller on")
    refused(apc(*argv, "number"), 3, "driver 'number': added_drivers_of_a_test:number is no function")
    refused(apc(*argv, "missing"), 3, "driver 'missing'", "cannot be loaded", "correct or remove its package")


@pytest.mark.usefixtures("added")
def test_a_driver_that_does_not_keep_to_the_protocol_is_told(made: Made) -> None:
    answer = apc("check-driver", "empty", made.plan, "--scene", made.scene)
    assert answer.code == 3 and answer.err.count("error:") == 1
    assert "driver empty: it executes the plan and arrives: stopped in" in answer.err
    assert "nothing is held" in answer.err and "FAILED  it executes the plan" in answer.out
    assert " not tried  its clock runs with its steps while it moves" in answer.out


def test_only_verified_plans_move_a_driver(made: Made, tmp_path: Path) -> None:
    plan = made.changed("move", tmp_path, lambda data: data.update(speed_scale=0.5))
    refused(apc("check-driver", "recorder", plan, "--scene", made.scene), 4, "edited after it was certified")
    refused(apc("check-driver", "recorder", made.plan, "--cell", "apc2016_delft"), 4, "made for the scene")


@pytest.mark.usefixtures("added")
def test_a_sensor_that_does_not_answer_ends_the_run(made: Made) -> None:
    answer = apc("execute", made.plan, "--scene", made.scene, "--driver", "silent")
    assert answer.code == 3 and "vacuum_sensor answers None, True or False expected" in answer.err


@pytest.mark.usefixtures("added")
@pytest.mark.parametrize("name", FAULTS)
def test_a_driver_that_fails_ends_the_run_by_one_message(made: Made, name: str) -> None:
    answer = apc("execute", made.move, "--scene", made.scene, "--driver", name)
    assert answer.code == 3 and answer.err.count("error:") == 1, answer.err
    assert f"driver {name}: {FAULTS[name]}" in answer.err and f"apc check-driver {name}" in answer.err


@pytest.mark.usefixtures("added")
@pytest.mark.parametrize("name", ["quits", "hasty", "unknown", "stands", "bare"])
def test_no_driver_passes_the_check_by_ending_it(made: Made, name: str) -> None:
    answer = apc("check-driver", name, made.move, "--scene", made.scene)
    assert answer.code == 3 and f"driver {name}: " in answer.err, answer.err
