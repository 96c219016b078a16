"""``apc suggest-mount``: the table, the JSON, the line for a cell file, and requests that make no sense."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.cell.data_path import data_path
from pickcli.commands.suggest_mount import command
from pickcli.reachability.mount_ranking import MountSettings
from support.bare_robot import write_bare_robot
from support.command_line import apc, refused

DOWN = "0.45,0.2,0.95,3.1416,0,0"
QUICK = ("suggest-mount", "--cell", "ur5e_crates", "--pose", DOWN, "--steps", 1, 3, 1, 1)


def test_the_line_stands_in_a_cell_as_it_is_told(tmp_path: Path) -> None:
    told = apc(*QUICK)
    assert told.code == 0
    assert [line.split()[0] for line in told.out.splitlines()[1:5]] == ["now", "1", "2", "3"]
    line = told.out.splitlines()[-1]
    shutil.copytree(data_path() / "cells" / "ur5e_crates", tmp_path / "mine")
    path = tmp_path / "mine" / "cell.yaml"
    lines = [line if each.startswith("  T_world_base:") else each for each in path.read_text().splitlines()]
    path.write_text("\n".join(lines) + "\n")
    best = json.loads(apc(*QUICK, "--json").out)["suggestions"][0]["T_world_base"]
    assert load_cell(str(tmp_path / "mine")).robot.T_world_base[:3, 3].tolist() == best["xyz"]


def test_the_json_has_the_shares_of_every_place() -> None:
    told = json.loads(apc("suggest-mount", "--steps", 1, 1, 1, 1, "--poses", 2, "--json").out)
    places = load_cell("apc2016_delft").places
    for each in (told["now"], *told["suggestions"]):
        assert list(each["shares"]) == list(places)
        assert each["share"] == pytest.approx(sum(each["shares"].values()) / len(places))
    assert told["yaml"].startswith("  T_world_base: {xyz: [-1.7580, 0.0000, 0.0000], rpy: [")


def test_the_defaults_are_those_of_the_settings() -> None:
    defaults = {parameter.name: parameter.default for parameter in command.params}
    assert (defaults["poses"], defaults["seed"]) == (MountSettings().n_poses, MountSettings().seed)


def test_a_cell_without_places_wants_poses(tmp_path: Path) -> None:
    bare = write_bare_robot(tmp_path)
    answer = apc("suggest-mount", "--cell", bare, "--steps", 1, 1, 1, 1)
    refused(answer, 3, "the cell has no places; state poses of the tool")


@pytest.mark.parametrize(
    ("words", "code", "told"),
    [
        (("--x", 1, 0), 3, "--x: expected two numbers within 100 of 0, the lower first, got 1 0"),
        (("--yaw", 0, 180), 3, "--yaw: expected"),
        (("--yaw", -90, 90), 3, "--yaw: expected angles within 6.3 rad, got -90 90; angles are in rad"),
        (("--pose", "0.4,0,1,0,180,0"), 3, "--pose: expected angles within 6.3 rad, got '0.4,0,1,0,180,0'"),
        (("--z", "nan", 0), 3, "--z: expected"),
        (("--steps", 100, 100, 100, 1), 3, "1000000 base poses; at most 20000"),
        (("--pose", "1,2,3"), 3, "--pose: expected x,y,z,roll,pitch,yaw in m and rad, got '1,2,3'"),
        (("--pose", "9,0,0,0,0,0"), 5, "reaches nothing"),
        (("--tool-state", "down"), 3, "unknown state of the tool 'down'"),
    ],
)
def test_what_makes_no_sense_is_refused(words: tuple[object, ...], code: int, told: str) -> None:
    rest = {"--cell": ("ur5e_crates",), "--steps": (1, 1, 1, 1), "--pose": (DOWN,)}
    if "--cell" in words:
        del rest["--pose"]
    given = [word for option, values in rest.items() if option not in words for word in (option, *values)]
    refused(apc("suggest-mount", *given, *words), code, told)
