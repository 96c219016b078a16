"""A cell of a robot alone: moves are planned and verified in it without a scene, picks are refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from pickcli.cell.cell_file import load_cell
from pickcli.motion.plan import RecoveryLevel
from pickcli.motion.plan_file import read_plan
from pickcli.simulation.camera_view import CELL_VIEW, view_of_motion
from support.bare_robot import write_bare_robot
from support.command_line import apc, misused, refused


@pytest.fixture(scope="module")
def cell(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_bare_robot(tmp_path_factory.mktemp("bare"))


@pytest.fixture(scope="module")
def move(cell: Path) -> Path:
    path = cell.parent / "move.json"
    done = apc("plan-move", "--cell", cell, "--from", "home", "--to", "away", "-o", path)
    assert (done.code, done.err) == (0, "")
    return path


def test_a_move_is_planned_and_verified_in_the_cell_alone(cell: Path, move: Path) -> None:
    verdict = apc("verify", move, "--cell", cell, "--json")
    assert verdict.code == 0 and json.loads(verdict.out)["accepted"]


def test_obstacles_of_the_cell_count_without_a_scene(cell: Path, move: Path, tmp_path: Path) -> None:
    walled = write_bare_robot(tmp_path)
    content = yaml.safe_load((walled / "cell.yaml").read_text())
    content["obstacles"].append({"name": "wall", "lower": [-1.6, -0.9, 1.5], "upper": [-1.1, 0.9, 3.0]})
    (walled / "cell.yaml").write_text(yaml.safe_dump(content))
    refused(apc("verify", move, "--cell", walled), 4, f"{move} in {walled}", "cell")
    told = apc(
        "plan-move", "--cell", walled, "--from", "home", "--to", "2.9,-0.6,1", "-o", tmp_path / "m.json"
    )
    refused(told, 5, "wall")


@pytest.fixture(scope="module")
def lonely(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cell without obstacles."""
    cell = write_bare_robot(tmp_path_factory.mktemp("lonely"))
    content = yaml.safe_load((cell / "cell.yaml").read_text()) | {"obstacles": []}
    (cell / "cell.yaml").write_text(yaml.safe_dump(content))
    return cell


@pytest.mark.parametrize("level", list(RecoveryLevel))
def test_a_recovery_is_judged_where_nothing_stands_around(
    lonely: Path, tmp_path: Path, level: RecoveryLevel
) -> None:
    path = tmp_path / "plan.json"
    assert apc("plan-move", "--cell", lonely, "--from", "home", "--to", "away", "-o", path).code == 0
    path.write_text(json.dumps(json.loads(path.read_text()) | {"recovery": level, "certificate": None}))
    verdict = apc("verify", path, "--cell", lonely, "--json")
    assert verdict.code in (0, 4) and "accepted" in json.loads(verdict.out), verdict.err


def test_neither_scene_nor_cell_is_a_question(move: Path, tmp_path: Path) -> None:
    misused(apc("verify", move), "--scene", "--cell")
    misused(apc("plan-move", "--from", "home", "--to", "away", "-o", tmp_path / "m.json"), "--cell")


@pytest.mark.parametrize(
    "words",
    [
        ("make-scene", "jsk_pick_sample", "-o", "scene.json"),
        ("build-roadmap", "-o", "roadmap.h5"),
        ("build-trajectories", "-o", "trajectories.h5"),
        ("suggest-configurations", "--bin", "bin_A", "-o", "bin_A.yaml"),
        ("compare-planners", "--pairs", "home-away"),
        ("run-trial", "jsk_pick_sample", "-o", "runs"),
    ],
)
def test_what_needs_places_says_so_in_a_sentence(
    words: tuple[str, ...], cell: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    refused(
        apc(*words, "--cell", cell), 3, "states no pod and no tote and ", "no tool", "docs/formats/cell.md"
    )
    assert not list(tmp_path.iterdir())


def test_a_move_claims_no_checks_of_items(cell: Path, move: Path) -> None:
    checks = json.loads(apc("verify", move, "--cell", cell, "--json").out)["certificate"]["checks"]
    kinds = [check.partition(":")[0] for check in checks]
    assert kinds == ["structure", "clearance", "limits", "lines", "tool speed", "motors", "events"]


def test_a_tool_that_no_joint_moves_never_moves(cell: Path, move: Path, tmp_path: Path) -> None:
    plan = json.loads(move.read_text()) | {"certificate": None}
    plan["segments"][0]["tool_state"] = "moving"
    (tmp_path / "moving.json").write_text(json.dumps(plan))
    refused(apc("verify", tmp_path / "moving.json", "--cell", cell), 4, "no joint moves the tool")


def test_a_move_of_another_cell_is_called_so(cell: Path, move: Path, tmp_path: Path) -> None:
    other = write_bare_robot(tmp_path)
    file = other / "cell.yaml"
    file.write_text(file.read_text().replace("clearance: 0.003", "clearance: 0.004"))
    refused(apc("execute", move, "--cell", other), 4, f"{move}: made for the cell ", "plan it again")


def test_a_typo_comes_with_what_was_meant(cell: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(cell.parent)
    for verb, known in (("check", "cell or task"), ("inspect", "cell")):
        refused(apc(verb, "cel"), 3, f"cel: no such file, and no {known} of that name; did you mean 'cell'?")
    refused(
        apc("plan-move", "--cell", "cel", "--from", "home", "--to", "away", "-o", "m.json"), 3, "mean 'cell'?"
    )


def test_a_blank_limit_says_who_knows_it(tmp_path: Path) -> None:
    cell = write_bare_robot(tmp_path)
    content = yaml.safe_load((cell / "cell.yaml").read_text())
    content["joint_limits"]["bend"] = {"has_jerk_limits": True, "max_jerk": None}
    (cell / "cell.yaml").write_text(yaml.safe_dump(content))
    told = "joint_limits.bend.max_jerk: expected a jerk limit in m/s3 or rad/s3, got nothing; state what the"
    refused(apc("check", cell), 3, told)


def test_a_cell_alone_is_drawn_and_a_film_shows_the_arm(cell: Path, move: Path, tmp_path: Path) -> None:
    assert apc("inspect", cell, "--picture", tmp_path / "cell.png").code == 0
    assert apc("inspect", cell, "--picture", tmp_path / "cell.html").code == 0
    assert (tmp_path / "cell.png").read_bytes().startswith(b"\x89PNG")
    robot = load_cell(cell)
    view = view_of_motion(robot, read_plan(move).trajectory.positions)
    base = robot.robot.T_world_base[:3, 3]
    assert np.linalg.norm(np.subtract(view.target, base)) < np.linalg.norm(np.subtract(view.eye, base)) < 5.0
    assert view_of_motion(load_cell("apc2016_delft"), np.zeros((2, 8))) == CELL_VIEW


def test_a_move_without_a_tool_is_simulated(cell: Path, move: Path) -> None:
    ran = apc("execute", move, "--cell", cell, "--json")
    assert ran.code == 0, ran.err


def test_spheres_and_configurations_are_told(cell: Path, tmp_path: Path) -> None:
    told = json.loads(apc("inspect", cell, "--json").out)["spheres"]
    assert told["lower"]["count"] > 1
    assert 0.0 < told["lower"]["mean_excess_m"] < told["lower"]["max_excess_m"] < 0.02
    assert "mm outside on average" in apc("inspect", cell).out
    assert "all 2 configurations are free" in apc("check", cell).out
    bent = write_bare_robot(tmp_path)
    content = yaml.safe_load((bent / "cell.yaml").read_text())
    content["obstacles"].append({"name": "box", "lower": [-1.5, -0.2, 1.2], "upper": [-0.9, 0.6, 2.0]})
    (bent / "cell.yaml").write_text(yaml.safe_dump(content))
    refused(apc("check", bent), 3, "cell.yaml:8:3: configurations[0].q: home is not free", "box")


def test_a_robot_without_tool_says_where_its_chain_ends(tmp_path: Path) -> None:
    cell = write_bare_robot(tmp_path)
    content = yaml.safe_load((cell / "cell.yaml").read_text())
    for tip, told in ((None, "robot.tip: expected the last link"), ("flnage", "did you mean 'flange'?")):
        robot = {key: value for key, value in content["robot"].items() if key != "tip"}
        robot |= {} if tip is None else {"tip": tip}
        (cell / "cell.yaml").write_text(yaml.safe_dump(content | {"robot": robot}))
        refused(apc("inspect", cell), 3, told)
    (cell / "cell.yaml").write_text(yaml.safe_dump(content) + "pod:\n")
    refused(apc("inspect", cell), 3, "pod: expected its figures, got nothing")
