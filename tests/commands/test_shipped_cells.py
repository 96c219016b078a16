"""The cells that ship: without mistakes, and from home to a certified and executed move."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.command_line import apc

ENDS = {"panda_table": "parked", "ur5e_crates": "parked", "apc2016_kth": "tote"}


@pytest.mark.parametrize("name", ENDS)
def test_a_move_is_planned_verified_and_executed(name: str, tmp_path: Path) -> None:
    move = tmp_path / "move.json"
    assert "a cell without mistakes" in apc("check", name).out
    planned = apc("plan-move", "--cell", name, "--from", "home", "--to", ENDS[name], "-o", move)
    assert planned.code == 0 and "certified" in planned.out
    assert "accepted" in apc("verify", move, "--cell", name).out
    assert "done" in apc("execute", move, "--cell", name).out
