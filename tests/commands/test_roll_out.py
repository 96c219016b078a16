"""``apc roll-out``: what a controller reaches, and what is told where it does not."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from pickcli.cell.data_path import data_path
from support.command_line import apc, refused

ITEM = "dove_beauty_bar"


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> Path:
    scene = tmp_path_factory.mktemp("table") / "scene.json"
    assert apc("make-scene", "--cell", "panda_table", "--in", f"mat_front={ITEM}", "-o", scene).code == 0
    return scene


def test_an_envelope_is_reached_and_every_instant_is_in_the_table(table: Path, tmp_path: Path) -> None:
    out = tmp_path / "run.csv"
    argv = ("roll-out", "grasp", "--scene", table, "--item", ITEM, "-o", out)
    told = json.loads(apc(*argv, "--json").out)
    assert told["end"] == "reached" and told["errors"]["envelope"] == 0.0
    rows = list(csv.DictReader(out.open()))
    assert len(rows) == told["instants"]
    assert [float(rows[-1][f"panda_joint{k}"]) for k in range(1, 8)] == told["q"]
    errors = [float(row["error_envelope"]) for row in rows]
    assert errors[0] > 0.0 == errors[-1]
    assert all(float(row["slack_1"]) < 1e-9 for row in rows[:-1])  # limits never give way
    first = out.read_bytes()
    text = apc(*argv, "--overwrite").out
    assert f"{told['envelope']} reached in {told['duration']:.2f} s" in text
    assert out.read_bytes() == first


def test_where_it_gets_stuck_the_level_that_gave_way_is_told(table: Path, tmp_path: Path) -> None:
    out = tmp_path / "run.csv"
    below = ("--envelope", "-z, closing along y")  # through the table
    answer = apc("roll-out", "grasp", "--scene", table, "--item", ITEM, *below, "-o", out, "--json")
    told = json.loads(answer.out)
    assert answer.code == told["exit_code"] == 5
    assert told["end"] != "reached" and told["errors"]["envelope"] > 0.0 and told["path"] == str(out)
    assert told["instants"] == len(out.read_text().splitlines()) - 1
    assert "-z, closing along y: after" in answer.err.replace("local minimum", "").replace(": : ", ": ") or (
        "(envelope) gave way most" in answer.err or "(obstacles) gave way most" in answer.err
    )
    assert "region query from there" in answer.err
    assert out.exists()


def test_mistakes_are_told_and_nothing_is_written(table: Path, tmp_path: Path) -> None:
    out = tmp_path / "run.csv"
    argv = ("roll-out", "grasp", "--scene", table, "-o", out)
    refused(apc(*argv, "--item", "soap"), 3, "unknown item 'soap'")
    refused(apc(*argv, "--item", ITEM, "--envelope", "top"), 3, "unknown envelope 'top'")
    refused(apc("roll-out", "reach", "--scene", table, "--item", ITEM, "-o", out), 3, "--approach reactive")
    refused(apc("roll-out", "gras", "--scene", table, "--item", ITEM, "-o", out), 3, "gras")
    refused(apc(*argv[:-1], tmp_path / "run.txt", "--item", ITEM), 3, "written as .csv")
    mine = tmp_path / "mine.yaml"
    text = (data_path() / "stacks" / "grasp.yaml").read_text()
    mine.write_text(text.replace("to: home", "to: nowhere"))
    refused(
        apc("roll-out", mine, "--scene", table, "--item", ITEM, "-o", out),
        3,
        "unknown configuration 'nowhere'",
    )
    mine.write_text(text.replace("goal: envelope", "goal: posture"))
    refused(
        apc("roll-out", mine, "--scene", table, "--item", ITEM, "-o", out), 3, mine, "state goal: envelope"
    )
    assert not out.exists()


def test_a_ball_that_fingers_just_span_is_reached_within_the_limits(tmp_path: Path) -> None:
    scene, out = tmp_path / "ball.json", tmp_path / "run.csv"
    apc("make-scene", "--cell", "panda_table", "--in", "mat_front=rawlings_baseball", "-o", scene)
    told = json.loads(
        apc("roll-out", "grasp", "--scene", scene, "--item", "rawlings_baseball", "-o", out, "--json").out
    )
    assert told["end"] == "reached" and told["duration"] < 8.0


def test_a_start_in_collision_is_told_and_nothing_is_written(table: Path, tmp_path: Path) -> None:
    out = tmp_path / "run.csv"
    argv = ("roll-out", "grasp", "--scene", table, "--item", ITEM, "-o", out)
    refused(apc(*argv, "--from", "0,1.7,0,-0.1,0,1.5,0"), 5, "start: collision: panda_leftfinger")
    assert not out.exists()
