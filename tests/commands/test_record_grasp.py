"""``apc record-grasp``, and ``apc plan-pick --grasps`` of what it wrote."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from pickcli.motion.plan_file import read_plan
from support.command_line import ITEM, Made, apc, misused, pick, refused

STATED = ("record-grasp", "--item", "dove_beauty_bar", "--grasp", "0,0,20,180,0,0")


def test_a_plans_grasp_is_recorded_and_planned_with_again(made: Made, tmp_path: Path) -> None:
    grasps, plan = tmp_path / "grasps.json", read_plan(made.plan)
    told = apc("record-grasp", "--plan", made.plan, "-o", grasps, "--json")
    assert told.code == 0 and json.loads(told.out)["item"] == ITEM
    assert pick(made.scene, tmp_path / "again.json", "--grasps", grasps).code == 0
    replanned = read_plan(tmp_path / "again.json")
    assert plan.grasp is not None and replanned.grasp is not None and replanned.certificate is not None
    assert np.allclose(replanned.grasp.T_item_tip, plan.grasp.T_item_tip, atol=1e-6)


def test_the_cell_of_a_plan_is_named_if_it_is_another(made: Made, tmp_path: Path) -> None:
    words = ("record-grasp", "--plan", made.plan, "-o", tmp_path / "grasps.json", "--cell")
    refused(
        apc(*words, "conveyor_sia20"),
        4,
        "was made for apc2016_delft, and this is conveyor_sia20; name the cell",
    )
    values = json.loads(made.plan.read_text()) | {"cell_fingerprint": "0" * 64, "certificate": None}
    unknown = tmp_path / "unknown.json"
    unknown.write_text(json.dumps(values))
    answer = apc("record-grasp", "--plan", unknown, "-o", tmp_path / "grasps.json")
    refused(answer, 4, f"was made for a cell of the fingerprint {'0' * 12}, and this is apc2016_delft")


def test_stated_grasps_are_added_to_a_file(tmp_path: Path) -> None:
    path = tmp_path / "grasps.json"
    assert apc(*STATED, "-o", path).code == 0
    added = apc(*STATED, "--pregrasp", "0,50,60,180,0,0", "--tool-state", "down", "--add", "-o", path)
    assert added.out == f"dove_beauty_bar of 2016, tool down: grasp 2 of {path}\n"
    first, second = json.loads(path.read_text())["grasps"]
    assert first["pregrasp"]["position"] == pytest.approx([0.0, 0.0, 0.12])
    assert second["pregrasp"]["position"] == pytest.approx([0.0, 0.05, 0.06])
    refused(apc(*STATED, "-o", path), 3, "exists")


@pytest.mark.parametrize(
    ("item", "message"),
    [("crayola_24_ct", "no recorded grasp: none of 1 is of"), (ITEM, "recorded grasp off the item: stated")],
)
def test_without_a_recorded_grasp_that_holds_there_is_no_plan(
    made: Made, tmp_path: Path, item: str, message: str
) -> None:
    path = tmp_path / "grasps.json"
    assert apc("record-grasp", "--item", item, "--grasp", "0,0,90,180,0,0", "-o", path).code == 0
    refused(pick(made.scene, tmp_path / "none.json", "--grasps", path), 5, message)
    assert not (tmp_path / "none.json").exists()


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        ((), "name a plan with --plan, or state --item and --grasp"),
        (("--plan", "p.json", "--item", "dove_beauty_bar"), "not both"),
        (("--item", "dove_beauty_bar"), "a stated grasp needs --item and --grasp"),
        (
            ("--item", "dove_beauty_bar", "--grasp", "1,2,3"),
            "expected X,Y,Z,ROLL,PITCH,YAW in mm and degrees",
        ),
        (("--item", "dove_beauty_bar", "--grasp", "0,0,nan,0,0,0"), "expected X,Y,Z,ROLL,PITCH,YAW"),
    ],
)
def test_contradictions_are_misuse(argv: tuple[str, ...], message: str, tmp_path: Path) -> None:
    misused(apc("record-grasp", *argv, "-o", tmp_path / "g.json"), message)
    assert not (tmp_path / "g.json").exists()


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (("--item", "dove_beauty_ba", "--grasp", "0,0,20,180,0,0"), "unknown item 'dove_beauty_ba'"),
        ((*STATED[1:], "--tool-state", "open"), "unknown state of the tool 'open'"),
        (("--item", "dove_beauty_bar", "--grasp", "0,0,900,180,0,0"), "0.90 m from the middle of the item"),
        ((*STATED[1:], "--pregrasp", "0,0,20,180,0,0"), "pregrasp: 0.0 mm from the grasp"),
        (("--plan", "no_such.json"), "no_such.json"),
    ],
)
def test_what_cannot_be_recorded_is_refused(argv: tuple[str, ...], message: str, tmp_path: Path) -> None:
    refused(apc("record-grasp", *argv, "-o", tmp_path / "g.json"), 3, message)
    assert not (tmp_path / "g.json").exists()


def test_grasps_come_from_one_source_and_are_not_overwritten(made: Made, tmp_path: Path) -> None:
    path = tmp_path / "grasps.json"
    assert apc(*STATED, "-o", path).code == 0
    by_region = pick(made.scene, tmp_path / "p.json", "--grasps", path, "--approach", "region")
    misused(by_region, "both say where grasps come from")
    before = path.read_bytes()
    assert pick(made.scene, path, "--grasps", path, "--overwrite").code == 3
    assert path.read_bytes() == before


def test_a_scene_is_no_file_of_grasps(made: Made, tmp_path: Path) -> None:
    answer = pick(made.scene, tmp_path / "p.json", "--grasps", made.scene)
    refused(answer, 3, "is a scene, but a file of recorded grasps is expected here")
