"""The cells that ship: without mistakes, and from home to a certified and executed move."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from support.command_line import apc

MOVES = {  # by cell and arm: from home to where
    ("panda_table", None): "parked",
    ("ur5e_crates", None): "parked",
    ("pr2_belt", "left"): "belt",
    ("pr2_belt", "right"): "bin_right",
    ("apc2016_kth", "right"): "tote",
    ("apc2016_kth", "left"): "tote",
    ("apc2016_kth_picking", "right"): "drop_0",
    ("apc2016_kth_picking", "left"): "drop_0",
    ("apc2016_delft_pinch", "suction"): "bin_A",
    ("apc2016_delft_pinch", "fingers"): "bin_A",
}


@pytest.mark.parametrize(("name", "arm"), MOVES)
def test_a_move_is_planned_verified_and_executed(name: str, arm: str | None, tmp_path: Path) -> None:
    move, of_arm = tmp_path / "move.json", () if arm is None else ("--arm", arm)
    assert "configurations are free" in apc("check", name).out
    ends = ("--from", "home", "--to", MOVES[name, arm])
    planned = apc("plan-move", "--cell", name, *of_arm, *ends, "-o", move)
    assert planned.code == 0 and "certified" in planned.out
    assert "accepted" in apc("verify", move, "--cell", name).out
    assert "done" in apc("execute", move, "--cell", name).out


def test_fingers_bring_an_item_from_a_mat_to_the_tray(tmp_path: Path) -> None:
    scene, pick, film = tmp_path / "scene.json", tmp_path / "pick.json", tmp_path / "pick.gif"
    item = "dove_beauty_bar"
    made = apc("make-scene", "--cell", "panda_table", "--in", f"mat_front={item}", "-o", scene)
    assert made.code == 0
    planned = apc(
        "plan-pick", "--scene", scene, "--bin", "mat_front", "--item", item, "--into", "tray", "-o", pick
    )
    assert planned.code == 0 and "certified" in planned.out
    played = json.loads(apc("execute", pick, "--scene", scene, "--video", film, "--json").out)
    assert (played["item_is_in"], played["collisions"], played["limit_violations"]) == ("tray", 0, 0)
    assert [event["action"] for event in played["execution"]["events"]] == ["closed", "open"]
    assert film.stat().st_size > 10_000
