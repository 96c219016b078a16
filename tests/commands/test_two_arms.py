"""Two arms on the command line: one moves, the other stands, and a plan knows where."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pickcli.cell.cell import ArmState
from pickcli.cell.cell_file import load_workcell
from pickcli.errors import StaleError
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.store import read_database, read_roadmap, write_database, write_roadmap
from pickcli.roadmap.trajectory_database import TrajectoryDatabase
from support.command_line import apc, refused
from support.stored_samples import MADE
from support.two_arms import content, write_cell, write_two_arms

ACROSS = ("--standing", "right=across")


@pytest.fixture(scope="module")
def cell(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_two_arms(tmp_path_factory.mktemp("arms"))


@pytest.fixture(scope="module")
def plan(cell: Path) -> Path:
    """Of the left arm, round the right one that reaches across."""
    path = cell.parent / "round.json"
    ends = ("--from=-1.2,0.8,0.1", "--to=-1.2,-0.8,0.1")
    done = apc("plan-move", "--cell", cell, "--arm", "left", *ACROSS, *ends, "-o", path)
    assert (done.code, done.err) == (0, "")
    assert "arm left" in done.out and "arm right stands at 1.0000,0.0000,0.0000" in done.out
    return path


def test_without_the_other_arm_in_its_way_the_motion_is_short(cell: Path, plan: Path) -> None:
    short = cell.parent / "short.json"
    words = ("--from=-1.2,0.8,0.1", "--to=-1.2,-0.8,0.1", "-o", short, "--json")
    done = apc("plan-move", "--cell", cell, "--arm", "left", *words)
    assert done.code == 0, done.err
    told = json.loads(apc("inspect", plan, "--json").out)
    assert told["duration_s"] > 1.5 * json.loads(done.out)["duration_s"]


def test_a_plan_names_its_arm_and_where_the_other_stood(cell: Path, plan: Path) -> None:
    written = json.loads(plan.read_text())
    assert written["arm"] == "left"
    assert written["others"] == [{"arm": "right", "q": [1.0, 0.0, 0.0], "tool_state": "fixed"}]
    assert json.loads(apc("inspect", plan, "--json").out)["arm"] == "left"


def test_it_is_verified_and_executed_where_the_other_stands_so(cell: Path, plan: Path) -> None:
    assert apc("verify", plan, "--cell", cell, *ACROSS).code == 0
    done = apc("execute", plan, "--cell", cell, "--standing", "right=1,0,0")
    assert done.code == 0 and "done" in done.out


@pytest.mark.parametrize("how", [(), ("--standing", "right=home"), ("--standing", "right=1,0,0.001")])
@pytest.mark.parametrize("command", ["verify", "execute"])
def test_it_is_refused_where_the_other_stands_elsewhere(
    cell: Path, plan: Path, command: str, how: tuple[str, ...]
) -> None:
    told = apc(command, plan, "--cell", cell, *how)
    refused(told, 4, "made while arm right stood at 1.0000,0.0000,0.0000 (tool fixed), it stands at")


def test_unverified_it_is_refused_too(cell: Path, plan: Path) -> None:
    told = apc("execute", plan, "--cell", cell, "--no-verify")
    assert told.code == 4 and "made while arm right stood at" in told.err


def test_a_plan_whose_other_arm_was_edited_is_damaged(cell: Path, plan: Path, tmp_path: Path) -> None:
    edited = tmp_path / "edited.json"
    written = json.loads(plan.read_text())
    written["others"][0]["q"] = [-1.5, 1.0, 0.3]
    edited.write_text(json.dumps(written))
    refused(apc("verify", edited, "--cell", cell), 4, "certificate.seal: edited after it was certified")
    written["certificate"] = None
    edited.write_text(json.dumps(written))
    refused(apc("verify", edited, "--cell", cell), 4, "the plan was made for the cell")


def test_a_plan_for_another_arm_or_cell_is_refused(cell: Path, plan: Path, tmp_path: Path) -> None:
    renamed = tmp_path / "renamed.json"
    written = json.loads(plan.read_text()) | {"arm": "middle", "certificate": None}
    renamed.write_text(json.dumps(written))
    refused(apc("verify", renamed, "--cell", cell), 4, "made for arm middle", "has the arms left, right")
    refused(apc("verify", plan, "--cell", "apc2016_delft"), 4, "made for arm left", "one arm")


def test_the_arm_follows_from_its_configurations(cell: Path, tmp_path: Path) -> None:
    changed = content()
    changed["configurations"].append({"name": "only", "arm": "right", "kind": "midway", "q": [-1, 0.5, 0]})
    folder = write_two_arms(tmp_path)
    write_cell(folder, changed)
    out = ("-o", tmp_path / "m.json", "--json", "--overwrite")
    for ends, arm in ((("home", "parked"), "left"), (("home", "only"), "right")):
        done = apc("plan-move", "--cell", folder, "--from", ends[0], "--to", ends[1], *out)
        assert done.code == 0 and json.loads(done.out)["arm"] == arm


def test_what_is_said_of_arms_must_fit_the_cell(cell: Path, tmp_path: Path) -> None:
    out = ("-o", tmp_path / "m.json")
    move = ("plan-move", "--cell", cell, "--from", "home", "--to", "parked", *out)
    refused(apc(*move, "--arm", "lefd"), 3, "unknown arm 'lefd'; did you mean 'left'?")
    refused(apc(*move, "--standing", "across"), 3, "expected ARM=NAME or ARM=q")
    refused(apc(*move, "--standing", "rigt=across"), 3, "rigt", "right")
    refused(apc(*move, "--standing", "right=acros"), 3, "acros", "across")
    refused(apc(*move, "--standing", "right=0,0"), 3, "got 2 of 3 numbers")
    refused(apc(*move, "--arm", "left", "--standing", "left=home"), 3, "the one that moves")
    numbers = ("plan-move", "--cell", cell, "--from=0,0,0", "--to=0,0,0.1", *out)
    refused(apc(*numbers), 3, "has the arms left and right; say which with --arm NAME")
    one = ("plan-move", "--cell", "apc2016_delft", "--from", "home", "--to", "bin_A", *out)
    refused(apc(*one, "--arm", "left"), 3, "has one arm")


def test_an_arm_that_cannot_stand_there_is_refused_before_planning(cell: Path, tmp_path: Path) -> None:
    move = ("plan-move", "--cell", cell, "--arm", "left", "--to", "parked", "-o", tmp_path / "m.json")
    in_torso = apc(*move, "--from", "home", "--standing", "right=2,0,0")
    refused(in_torso, 3, "arm right cannot stand at 2.0000,0.0000,0.0000", "torso")
    in_arm = apc(*move, "--from=-1.2,0.1,0.1", *ACROSS)
    refused(in_arm, 3, "arm right cannot stand at 1.0000,0.0000,0.0000", "left_lower")


def test_a_parked_arm_that_collides_is_found_by_check(tmp_path: Path) -> None:
    folder, changed = write_two_arms(tmp_path), content()
    changed["obstacles"] = [{"name": "cart", "lower": [-0.3, -1.2, 0.0], "upper": [0.4, -0.6, 0.5]}]
    write_cell(folder, changed)
    told = apc("check", folder)
    refused(told, 3, "parked of arm right is not free", "cart")
    move = apc("plan-move", "--cell", folder, "--from", "home", "--to", "parked", "-o", tmp_path / "m.json")
    refused(move, 3, "arm right cannot stand at", "cart")


def test_inspect_shows_all_arms_or_one(cell: Path) -> None:
    whole = json.loads(apc("inspect", cell, "--json").out)
    one = json.loads(apc("inspect", cell, "--arm", "right", "--json").out)
    assert list(whole["arms"]) == ["left", "right"] and whole["name"] == one["name"] == "two_arms"
    assert whole["arms"]["right"]["fingerprint"] == one["fingerprint"]
    assert whole["arms"]["left"]["preference"] == 1


def test_a_roadmap_and_a_database_are_of_one_arm_beside_others_where_they_stand(
    cell: Path, tmp_path: Path
) -> None:
    workcell = load_workcell(cell)
    left = workcell.arms["left"]
    names = left.robot.joint_names
    empty = TrajectoryDatabase.of(names, [])
    write_roadmap(tmp_path / "r.h5", Roadmap.empty(names), left.fingerprint, MADE)
    write_database(tmp_path / "t.h5", empty, left.fingerprint, MADE)
    assert read_roadmap(tmp_path / "r.h5", left).joint_names == names
    assert read_database(tmp_path / "t.h5", left).joint_names == names
    across = workcell.arms["right"].configurations["across"]
    beside = workcell.cell("left", [ArmState("right", across.q, across.tool_state)])
    for other in (workcell.arms["right"], beside):
        with pytest.raises(StaleError):
            read_roadmap(tmp_path / "r.h5", other)
        with pytest.raises(StaleError):
            read_database(tmp_path / "t.h5", other)
