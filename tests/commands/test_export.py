"""``apc export``: what it writes, verifies and refuses."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from pickcli.export.formats import BUILT_IN
from support.command_line import Made, apc, misused, refused

SUFFIX = {"joint-trajectory": ".json", "csv": ".csv", "mcap": ".mcap", "urscript": ".script"}


@pytest.mark.parametrize("name", sorted(SUFFIX.keys() - {"urscript"}))
def test_a_pick_is_written_twice_the_same(name: str, made: Made, tmp_path: Path) -> None:
    written = [tmp_path / f"{k}{SUFFIX[name]}" for k in range(2)]
    for path in written:
        answer = apc("export", made.plan, "--scene", made.scene, "--format", name, "-o", path)
        assert answer.code == 0, answer.err
        assert answer.out.startswith(f"wrote {path}: ")
    assert written[0].read_bytes() == written[1].read_bytes() != b""


def test_its_answer_in_json_tells_what_was_written(made: Made, tmp_path: Path) -> None:
    path = tmp_path / "plan.csv"
    answer = apc(
        "export", made.move, "--scene", made.scene, "--format", "csv", "--rate", "100", "-o", path, "--json"
    )
    told = json.loads(answer.out)
    assert (told["exit_code"], told["format"], told["path"]) == (0, "csv", str(path))
    assert told["bytes"] == path.stat().st_size


def test_a_move_of_a_ur_becomes_a_program(tmp_path: Path) -> None:
    move, program = tmp_path / "move.json", tmp_path / "move.script"
    assert (
        apc("plan-move", "--cell", "ur5e_crates", "--from", "home", "--to", "crate_left", "-o", move).code
        == 0
    )
    argv = (
        "export",
        move,
        "--cell",
        "ur5e_crates",
        "--format",
        "urscript",
        "--channel",
        "valve=3",
        "-o",
        program,
    )
    answer = apc(*argv)
    assert answer.code == 0, answer.err
    text = program.read_text()
    assert "# digital output 3: valve" in text and text.count("servoj(") > 60


def test_the_help_lists_every_format() -> None:
    text = " ".join(apc("export", "--help").out.split())
    assert ", ".join(BUILT_IN) in text


def faster(plan: dict[str, Any]) -> None:
    """A fifth of the time, and no certificate."""
    plan["certificate"] = None
    for segment in plan["segments"]:
        segment["t_start"], segment["t_end"] = segment["t_start"] / 5, segment["t_end"] / 5
    for point in plan["trajectory"]["points"]:
        point["time_from_start"] /= 5


def shifted(plan: dict[str, Any]) -> None:
    plan["trajectory"]["points"][3]["positions"][0] += 1e-9


def test_what_the_verifier_rejects_does_not_leave(made: Made, tmp_path: Path) -> None:
    out, plan = tmp_path / "out.csv", made.changed("move", tmp_path, faster)
    refused(apc("export", plan, "--scene", made.scene, "--format", "csv", "-o", out), 4, plan, "velocity")
    assert not out.exists()


def test_a_plan_that_was_edited_does_not_leave(made: Made, tmp_path: Path) -> None:
    out, plan = tmp_path / "out.csv", made.changed("plan", tmp_path, shifted)
    answer = apc("export", plan, "--scene", made.scene, "--format", "csv", "-o", out)
    refused(answer, 4, plan, "edited after it was certified")
    assert not out.exists()


def test_a_plan_without_a_certificate_is_verified_and_leaves(made: Made, tmp_path: Path) -> None:
    plan = made.changed("move", tmp_path, lambda data: data.update(certificate=None))
    answer = apc("export", plan, "--scene", made.scene, "--format", "csv", "-o", tmp_path / "out.csv")
    assert answer.code == 0 and "has no certificate; it was verified now and accepted" in answer.err


def test_a_plan_of_another_scene_does_not_leave(made: Made, tmp_path: Path) -> None:
    out = tmp_path / "out.csv"
    answer = apc("export", made.plan, "--cell", "apc2016_delft", "--format", "csv", "-o", out)
    refused(answer, 4, made.plan, "made for the scene")
    assert not out.exists()


@pytest.mark.parametrize("rate", ["0", "-5", "1e9", "nan"])
def test_rates_that_cannot_be_are_wrong_usage(rate: str, made: Made, out: Path) -> None:
    argv = ("export", made.move, "--scene", made.scene, "--format", "joint-trajectory", "-o", out)
    misused(apc(*argv, "--rate", rate), "Invalid value for '--rate'")
    assert not out.exists()


def test_a_rate_by_which_the_motion_is_left_is_refused(made: Made, out: Path) -> None:
    argv = ("export", made.move, "--scene", made.scene, "--format", "joint-trajectory", "-o", out)
    refused(apc(*argv, "--rate", "1.5"), 3, made.move, "leave the verified motion by")
    assert not out.exists()


def test_what_is_no_plan_is_called_by_its_name(made: Made, out: Path) -> None:
    argv = ("--scene", made.scene, "--format", "joint-trajectory", "-o", out)
    refused(apc("export", made.scene, *argv), 3, "scene.json: is a scene, but a plan is expected here")
    refused(apc("export", out.with_name("none.json"), *argv), 3, "none.json")
    assert not out.exists()


def test_places_that_cannot_be_written_are_refused_before_any_work(made: Made, tmp_path: Path) -> None:
    argv = ("export", made.move, "--scene", made.scene, "--format", "csv", "-o")
    there = tmp_path / "there.csv"
    there.write_text("mine")
    refused(apc(*argv, there), 3, there, "exists already")
    assert there.read_text() == "mine"
    assert apc(*argv, there, "--overwrite").code == 0 and there.read_text() != "mine"
    refused(apc(*argv, tmp_path / "none" / "out.csv"), 3, "does not exist; make it first")
    refused(apc(*argv, tmp_path / "out.txt"), 3, "the format csv is written as .csv; name such a file")


def test_a_plan_is_not_replaced_by_its_own_export(made: Made) -> None:
    argv = (
        "export",
        made.move,
        "--scene",
        made.scene,
        "--format",
        "joint-trajectory",
        "-o",
        made.move,
        "--overwrite",
    )
    refused(apc(*argv), 3, "is an input of this command")


def test_wrong_usage_is_told(made: Made, tmp_path: Path) -> None:
    argv = ("export", made.move, "--scene", made.scene)
    csv = ("--format", "csv", "-o", tmp_path / "out.csv")
    script = ("--format", "urscript", "-o", tmp_path / "out.script")
    misused(apc(*argv, *csv, "--channel", "valve=1"), "the format csv has no channels")
    for text in ("valve", "valve=x", "valve=-1", "valve=", "valve=" + 5000 * "9"):
        misused(apc(*argv, *script, "--channel", text), "expected DEVICE=N")
    misused(apc(*argv, *script, "--channel", "valve=1", "--channel", "valve=2"), "given twice")
    misused(apc("export", made.move, *csv), "no surroundings")
    misused(apc(*argv, "--format", "ros", "-o", tmp_path / "out.json"), "unknown format 'ros'")
    refused(apc(*argv, *script), 3, "URScript is for the six joints of Universal Robots")
