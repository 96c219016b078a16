"""Home and parking configuration of a new cell: a motion leads between them, or the report says why."""

from __future__ import annotations

from pathlib import Path

from pickcli.cell.cell_file import load_cell
from support.command_line import apc
from support.elbow import LIMITS, WALL, write_elbow


def test_a_motion_may_begin_at_home_although_the_tool_moves_best_nearer_to_a_wall(tmp_path: Path) -> None:
    cell, move = tmp_path / "cell", tmp_path / "move.json"
    made = apc("init", cell, "--urdf", write_elbow(tmp_path, 0.2, 2.9, WALL), *LIMITS)
    assert made.code == 0 and "left to fill in" not in made.out, made.err
    assert {"home", "parked"} <= set(load_cell(cell).configurations)
    planned = apc("plan-move", "--cell", cell, "--from", "home", "--to", "parked", "-o", move)
    assert planned.code == 0 and "certified" in planned.out, planned.err


def test_a_cell_in_which_nothing_is_parked_says_so(tmp_path: Path) -> None:
    cell = tmp_path / "cell"
    made = apc("init", cell, "--urdf", write_elbow(tmp_path, 1.7, 2.0, WALL), *LIMITS)
    assert made.code == 0
    assert set(load_cell(cell).configurations) == {"home"}
    left = made.out.partition("left to fill in")[2]
    assert "no plan for a motion from home to" in left and "as parked" in left, made.out
