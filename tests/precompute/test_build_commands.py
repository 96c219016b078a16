"""``apc build-roadmap`` and ``apc build-trajectories``: what they print and what they leave."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from pickcli.cell import cell_file
from pickcli.commands.build_roadmap import command as build_roadmap
from pickcli.commands.build_trajectories import command as build_trajectories
from pickcli.errors import InputError
from pickcli.precompute.artifact_files import make_roadmap, make_trajectories
from pickcli.precompute.roadmap_settings import RoadmapSettings
from pickcli.roadmap.store import describe
from pickcli.trajopt.trajectory_settings import TrajectorySettings
from support.small_cell import alone, small_cell


@pytest.fixture(autouse=True)
def few_configurations(monkeypatch: pytest.MonkeyPatch) -> None:
    cell = small_cell("home", "bin_A", "tote", "tote_10h")
    monkeypatch.setattr(cell_file, "load_workcell", lambda *_: alone(cell))


@pytest.mark.parametrize(
    ("command", "more", "counted"),
    [
        (build_roadmap, ["--planner", "RRTConnect", "--nearest", "2"], "edges"),
        (build_trajectories, ["--tries", "1"], "motions"),
    ],
)
def test_json_is_one_object_and_the_file_says_how_it_was_made(
    command: click.Command, more: list[str], counted: str, tmp_path: Path
) -> None:
    output = tmp_path / "out.h5"
    result = CliRunner().invoke(command, ["-o", str(output), "--seed", "3", "--json", *more])
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert told[counted] > 0
    assert any("tote_10h" in line for line in [*told.get("refused", []), *told["missing"]])
    made = describe(output)["made"]
    assert made["settings"]["seed"] == 3 and made["settings"]["planner"] == "RRTConnect"
    again = CliRunner().invoke(command, ["-o", str(output)])
    assert isinstance(again.exception, InputError) and "--overwrite" in str(again.exception)


@pytest.mark.parametrize(
    ("command", "make", "settings"),
    [
        (build_roadmap, make_roadmap, RoadmapSettings()),
        (build_trajectories, make_trajectories, TrajectorySettings()),
    ],
)
def test_without_options_it_is_what_a_trial_builds(
    command: click.Command,
    make: Callable[..., object],
    settings: RoadmapSettings | TrajectorySettings,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    cell = small_cell("home", "bin_A")
    monkeypatch.setattr(cell_file, "load_workcell", lambda *_: alone(cell))
    told, made = tmp_path / "told.h5", tmp_path / "made.h5"
    assert CliRunner().invoke(command, ["-o", str(told), "--jobs", "1"]).exit_code == 0
    make(cell, made)
    assert describe(told)["made"]["settings"] == asdict(settings)
    assert told.read_bytes() == made.read_bytes()


def test_text_names_what_is_not_free(tmp_path: Path) -> None:
    arguments = ["-o", str(tmp_path / "r.h5"), "--planner", "RRTConnect"]
    result = CliRunner().invoke(build_roadmap, arguments)
    assert result.exit_code == 0
    assert "3 nodes" in result.stdout
    assert "not free: tote_10h: tool anywhere from straight to down: collision" in result.stdout


def test_an_unknown_planner_is_a_usage_error(tmp_path: Path) -> None:
    result = CliRunner().invoke(build_roadmap, ["-o", str(tmp_path / "r.h5"), "--planner", "PRM"])
    assert result.exit_code == 2 and "'rrtconnect'" in result.stderr
