"""A planner of one arm of several: which one moves, and where the others stand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import pickcli
from pickcli import InputError, Planner, StaleError, UnknownNameError
from support.command_line import apc
from support.two_arms import write_two_arms

START, GOAL = (-1.2, 0.8, 0.1), (-1.2, -0.8, 0.1)


@pytest.fixture(scope="module")
def cell(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_two_arms(tmp_path_factory.mktemp("arms"))


@pytest.fixture(scope="module")
def across(cell: Path) -> Planner:
    return Planner.load(cell, arm="left", standing={"right": "across"})


def test_the_arm_is_named_where_there_are_several(cell: Path, across: Planner) -> None:
    with pytest.raises(InputError, match="has the arms left and right"):
        Planner.load(cell)
    assert across.cell.arm == "left"
    np.testing.assert_allclose(across.cell.others[0].q, (1.0, 0.0, 0.0))
    np.testing.assert_allclose(Planner.load(cell, arm="right").cell.others[0].q, (1.5, 1.0, 0.3))


def test_a_move_goes_round_an_arm_and_a_plan_of_the_command_is_taken(
    cell: Path, across: Planner, tmp_path: Path
) -> None:
    file = tmp_path / "move.json"
    words = ("--cell", cell, "--arm", "left", "--standing", "right=across")
    assert apc("plan-move", *words, f"--from={_text(START)}", f"--to={_text(GOAL)}", "-o", file).code == 0
    here, there = across.plan_move(START, GOAL), pickcli.read_plan(file)
    assert across.verify(there).certificate is not None and across.verify(here).certificate is not None
    parked = Planner.load(cell, arm="left").plan_move(START, GOAL)
    assert parked.trajectory.duration < 0.7 * here.trajectory.duration
    with pytest.raises(StaleError):
        across.verify(parked)


def test_a_scene_is_of_all_arms(cell: Path, across: Planner) -> None:
    right = Planner.load(cell, arm="right", standing={"left": [0.3, 0.2, 0.4]})
    plan = right.plan_move("home", "parked", across.scene)
    assert right.verify(plan, across.scene).certificate is not None


def test_where_other_arms_cannot_stand_is_told(cell: Path, across: Planner) -> None:
    with pytest.raises(UnknownNameError, match="unknown arm 'rigth'; did you mean 'right'"):
        Planner.load(cell, arm="left", standing={"rigth": "home"})
    with pytest.raises(UnknownNameError, match="unknown configuration 'acros'; did you mean 'across'"):
        Planner.load(cell, arm="left", standing={"right": "acros"})
    with pytest.raises(InputError, match="say only where other arms stand"):
        Planner.load(cell, arm="left", standing={"left": "home"})
    with pytest.raises(InputError, match="limits are"):
        Planner.load(cell, arm="left", standing={"right": (0.0, 90.0, 0.0)})
    with pytest.raises(InputError, match="is given as one arm sees it"):
        Planner.load(across.cell, arm="right")
    meeting = Planner.load(cell, arm="left", standing={"right": [1.0, 0.0, 0.0]})
    with pytest.raises(InputError, match=r"arm right cannot stand at 1.0000,0.0000,0.0000 .*: collision"):
        meeting.plan_move("across", "home")


def _text(q: tuple[float, ...]) -> str:
    return ",".join(f"{value:g}" for value in q)
