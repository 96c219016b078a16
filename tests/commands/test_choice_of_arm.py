"""Two robots before one shelf: who picks what, and why; each plan is of one of them beside the other."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from pickcli.cell.cell_file import load_workcell
from pickcli.errors import NoPlanError, Reason
from pickcli.motion.plan import Plan
from pickcli.planning.arm_choice import rank_arms
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.random_scenes.make_scene import make_scene
from pickcli.scene.scene_file import read_scene, write_scene
from support.command_line import apc, refused
from support.two_robots import content, write_two_robots

pytestmark = pytest.mark.slow

LEFT, RIGHT = "dove_beauty_bar", "crayola_24_ct"  # in a bin of the left and of the right column
MIDDLE = "command_hooks"


@pytest.fixture(scope="module")
def cell(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_two_robots(tmp_path_factory.mktemp("robots"))


@pytest.fixture(scope="module")
def scene(cell: Path) -> Path:
    path = cell.parent / "scene.json"
    seen = load_workcell(cell).preferred
    write_scene(make_scene({"bin_D": [LEFT], "bin_F": [RIGHT], "bin_E": [MIDDLE]}, seen, 1), path)
    return path


def pick(cell: Path, scene: Path, where: str, item: str, out: Path, *more: object) -> tuple[object, ...]:
    words = ("--scene", scene, "--cell", cell, "--bin", where, "--item", item, "-o", out)
    return ("plan-pick", *words, *more)


def test_a_scene_is_of_all_arms(cell: Path, scene: Path) -> None:
    for seen in load_workcell(cell).arms.values():
        assert read_scene(scene, seen).cell is seen


@pytest.mark.parametrize(("where", "item", "arm"), [("bin_D", LEFT, "left"), ("bin_F", RIGHT, "right")])
def test_the_arm_follows_from_reach(
    cell: Path, scene: Path, tmp_path: Path, where: str, item: str, arm: str
) -> None:
    plan = tmp_path / "plan.json"
    done = apc(*pick(cell, scene, where, item, plan, "--json"))
    assert done.code == 0, done.err
    told = json.loads(done.out)
    first = told["arms_ranked"][0]
    assert told["arm"] == first["arm"] == arm and first["n_reached"] > 0
    assert {each["arm"] for each in told["arms_ranked"]} == {"left", "right"}
    assert apc("verify", plan, "--cell", cell, "--scene", scene).code == 0
    other = "right" if arm == "left" else "left"
    told_elsewhere = apc("verify", plan, "--cell", cell, "--scene", scene, "--standing", f"{other}=home")
    refused(told_elsewhere, 4, f"made while arm {other} stood at")


def test_the_choice_is_explained(cell: Path, scene: Path, tmp_path: Path) -> None:
    done = apc(*pick(cell, scene, "bin_F", RIGHT, tmp_path / "plan.json"))
    first, second, *_ = done.out.splitlines()
    assert first.startswith("arm right: reaches ") and first.endswith(" grasps, preference 2")
    assert second.startswith("arm left: reaches none of ") and second.endswith(" grasps, preference 1")


def test_an_arm_that_is_named_is_taken(cell: Path, scene: Path, tmp_path: Path) -> None:
    told = apc(*pick(cell, scene, "bin_F", RIGHT, tmp_path / "plan.json", "--arm", "left"))
    refused(told, 5, f"no plan for pick {RIGHT} from bin_F")
    assert not (tmp_path / "plan.json").exists()


def test_where_no_arm_has_a_plan_each_is_told_with_its_own_reasons(
    cell: Path, scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_plan(context: PlanningContext, *_: object) -> Plan:
        raise NoPlanError("pick it", [Reason("joint limit", detail=context.cell.arm)] * 3)

    monkeypatch.setattr("pickcli.planning.pick.plan_pick", no_plan)
    told = apc(*pick(cell, scene, "bin_E", MIDDLE, tmp_path / "plan.json"))
    first, second = (line for line in told.err.splitlines() if line.startswith("  arm "))
    assert told.code == 5 and told.err.count("note: neither roadmap") == 1
    for line, arm in ((first, "left"), (second, "right")):
        assert line.startswith(f"  arm {arm}: reaches ")
        assert line.endswith(f": 3 times joint limit, e.g. joint limit: {arm}")


def test_a_pick_is_played_beside_the_other_robot(cell: Path, scene: Path, tmp_path: Path) -> None:
    plan = tmp_path / "plan.json"
    assert apc(*pick(cell, scene, "bin_D", LEFT, plan)).code == 0
    done = apc("execute", plan, "--cell", cell, "--scene", scene, "--json")
    assert done.code == 0, done.err


def test_the_preferred_arm_goes_first_where_both_reach(cell: Path, scene: Path) -> None:
    workcell = load_workcell(cell)
    scenes = [read_scene(scene, seen) for seen in workcell.arms.values()]
    query = PickQuery("bin_E", MIDDLE)
    for preferences, first in (({"left": 1, "right": 2}, "left"), ({"left": 2, "right": 1}, "right")):
        ranked = rank_arms(scenes, preferences, query)
        assert all(arm.is_able for arm in ranked) and ranked[0].arm == first
        assert ranked == rank_arms(scenes, preferences, query)
    alike = rank_arms(scenes, {"left": 1, "right": 1}, query)
    assert alike[0].n_reached >= alike[1].n_reached


def test_an_item_that_no_tool_holds_is_told_so(cell: Path, scene: Path, tmp_path: Path) -> None:
    workcell = load_workcell(cell)
    scenes = []
    for seen in workcell.arms.values():
        whole = read_scene(scene, seen)
        items = tuple(replace(p, item=replace(p.item, seals={})) for p in whole.items)
        scenes.append(replace(whole, items=items))
    ranked = rank_arms(scenes, workcell.preferences, PickQuery("bin_F", RIGHT))
    assert [arm.is_able for arm in ranked] == [False, False]
    assert str(ranked[0]).startswith(f"arm left: cannot hold it: {RIGHT}: cannot be held by suction")


def test_robots_of_one_kind_stand_side_by_side(cell: Path) -> None:
    workcell = load_workcell(cell)
    left, right = workcell.arms["left"].robot, workcell.arms["right"].robot
    assert left.joint_names[0] == "left_rail" and right.joint_names[0] == "right_rail"
    assert {link.name for link in left.links} == {link.name for link in right.links}
    assert content()["robots"]["left"]["urdf"] == content()["robots"]["right"]["urdf"]
