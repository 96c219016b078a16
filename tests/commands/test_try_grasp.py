"""``apc try-grasp``: one grasp told stage by stage, many counted, and mistakes in one line."""

from __future__ import annotations

import json
from pathlib import Path

from pickcli.cell.data_path import data_path
from support.command_line import apc, misused, refused


def test_one_grasp_is_told_stage_by_stage() -> None:
    offset = ("--offset", "0.01", "-0.02", "0", "--tilt", "0.1", "0")
    argv = ("try-grasp", "apple", "--object", "box_50", *offset)
    text = apc(*argv).out
    for stage in ("approach", "closing", "pull-in", "firm grasp", "lift"):
        assert stage in text
    told = json.loads(apc(*argv, "--json").out)
    assert (told["hand"], told["object"], told["grasps"]) == ("apple", "box_50", 1)
    (trial,) = told["trials"]
    assert trial["end"] == "lifted" and trial["end"] in text
    assert trial["pre_grasp"][3:] == [0.0, 0.0, 0.1]
    assert [stage["name"] for stage in trial["stages"]][-1] == "lift"
    assert f"{trial['most_force']:.1f} N on a pad" in text


def test_many_grasps_are_counted_and_the_same_seed_gives_the_same_text() -> None:
    argv = ("try-grasp", "apple", "--object", "can", "--poses", "near", "--grasps", "2", "--seed", "5")
    first = apc(*argv)
    assert first.code == 0 and "of 2 lifted" in first.out and "s in the mean" in first.out
    assert apc(*argv).out == first.out


def test_mistakes_are_told(tmp_path: Path) -> None:
    can = ("--object", "can")
    refused(apc("try-grasp", "appel", *can), 3, "unknown hand 'appel'", "apple")
    refused(apc("try-grasp", "apple", "--object", "cann"), 3, "unknown object 'cann'", "can")
    misused(apc("try-grasp", "apple", *can, "--poses", "near", "--tilt", "0", "0"), "leave out")
    misused(apc("try-grasp", "apple", *can, "--grasps", "3"), "--grasps is the number of grasps of --poses")
    for usage in (("--poses", "far"), ("--offset", "0.2", "0", "0"), ("--offset", "nan", "0", "0"),
                  ("--poses", "grid", "--grasps", "0")):  # fmt: skip
        answer = apc("try-grasp", "apple", *can, *usage)
        assert answer.code == 2 and answer.out == "" and "Invalid value for" in answer.err
    refused(apc("try-grasp", data_path() / "stacks" / "grasp.yaml", *can), 3, "stack of tasks", "a hand")
    mine = tmp_path / "mine.yaml"
    mine.write_text("format: apc hand\nversion: 1\n")
    refused(apc("try-grasp", mine, *can), 3, "fingers")
