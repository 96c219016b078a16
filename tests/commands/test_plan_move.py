"""``apc plan-move`` with a state of the tool at the goal, and ``apc execute`` of such a plan."""

from __future__ import annotations

import json
from pathlib import Path

from support.command_line import Made, apc, refused


def test_a_move_changes_the_state_of_the_tool(made: Made, out: Path) -> None:
    words = ("plan-move", "--scene", made.scene, "--from", "home", "--to", "bin_C", "--tool-state")
    refused(apc(*words, "sideways", "-o", out), 3, "unknown state of the tool 'sideways'")
    assert apc(*words, "down", "-o", out).code == 0
    plan = json.loads(out.read_text())
    assert [segment["tool_state"] for segment in plan["segments"]] == ["moving", "down"]
    assert apc("verify", out, "--scene", made.scene).code == 0
    told = json.loads(apc("execute", out, "--scene", made.scene, "--json").out)
    assert [event["action"] for event in told["execution"]["events"]] == ["down"]
    assert told["collisions"] == told["limit_violations"] == 0
    recorded = apc("execute", out, "--scene", made.scene, "--driver", "recorder", "--json")
    assert recorded.code == 0, recorded.err


def test_a_bridge_brings_the_tool_to_the_state_in_which_a_plan_begins(made: Made) -> None:
    """drop_00_down is meant for the cup down; the plan begins at home with the cup straight."""
    argv = ("execute", made.move, "--scene", made.scene, "--from", "drop_00_down")
    refused(apc(*argv), 3, "refusing to start")
    bridged = apc(*argv, "--bridge", "--json")
    assert bridged.code == 0, bridged.err
    assert [event["action"] for event in json.loads(bridged.out)["bridge"]["events"]] == ["straight"]
