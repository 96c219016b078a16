"""``apc locate-tote``: where the tote stands by touch, what becomes of that, or one message why not."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.geometry import pose
from pickcli.scene.scene import TOTE
from pickcli.scene.scene_file import pose_values, read_scene
from support.command_line import apc, refused

CELL = load_cell("apc2016_delft")
T_NOMINAL = CELL.T_world_place(CELL.places[TOTE])
MOVED = T_NOMINAL @ pose((0.01, -0.02, 0.001), rpy=(0.0, 0.0, 0.02))
BINS = [word for name in CELL.pod.bins for word in ("--empty", name)]


@pytest.fixture
def stated(tmp_path: Path) -> Path:
    """A file of a located tote."""
    touch = {"name": "1 wall left", "point": [0, 0, 0], "deviation": 1e-4, "bias": 3e-4}
    touch |= {"residual": 0.0, "force": 5.0}
    content = {
        "format": "apc tote", "version": 1,
        "cell": {"name": CELL.name, "fingerprint": CELL.scene_fingerprint},
        "pose": pose_values(MOVED), "error": {"x": 6e-4, "y": 5e-4, "z": 6e-4, "yaw": 0.0035},
        "covariance": np.eye(4).tolist(), "touches": [touch], "duration": 38.0, "seed": 1,
    }  # fmt: skip
    path = tmp_path / "tote.json"
    path.write_text(json.dumps(content))
    return path


def test_a_scene_believes_the_tote_to_be_where_it_was_located(stated: Path, tmp_path: Path) -> None:
    scene_path = tmp_path / "believed.json"
    answer = apc("believe", "--tote", stated, "--empty", "tote", *BINS, "-o", scene_path)
    assert answer.code == 0, answer.err
    scene = read_scene(scene_path)
    np.testing.assert_allclose(scene.T_world_place(scene.cell.places[TOTE]), MOVED, atol=1e-9)
    assert scene.carriers[TOTE].error.yaw == 0.0035
    move = tmp_path / "move.json"
    answer = apc("plan-move", "--scene", scene_path, "--from", "home", "--to", "drop_11", "-o", move)
    assert answer.code == 0, answer.err  # and is certified there
    assert apc("verify", move, "--scene", scene_path).code == 0


def test_believing_nothing_is_refused(tmp_path: Path) -> None:
    answer = apc("believe", "-o", tmp_path / "scene.json")
    assert answer.code == 2 and "nothing to believe" in answer.err
    assert not (tmp_path / "scene.json").exists()


@pytest.mark.parametrize(
    ("words", "told"),
    [(("--tote-shift", "31,0,0"), "31 mm, 0 mm and 0 degrees is beyond what touches reach"),
     (("--tote-shift", "0,0,3.1"), "beyond what touches reach"),
     (("--cell", "ur5e_crates"), "has no tote to be located"),
     (("--cell", "apc2016_delft_pinch"), "say which with --arm"),
     (("--cell", "apc2016_delft_pinch", "--arm", "fingers"), "its tool has no cup"),
     (("--cell", "apc2016_kth", "--arm", "left"), "its tool has no cup"),
     (("--cell", "nowhere"), "nowhere"),
     (("-o", "tote.yaml"), "tote.yaml")],
)  # fmt: skip
def test_bad_requests_have_one_message_and_leave_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], told: str
) -> None:
    monkeypatch.chdir(tmp_path)
    output = () if "-o" in words else ("-o", "tote.json")
    refused(apc("locate-tote", *words, *output), 3, told)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "told"),
    [(("--tote-shift", "1,2"), "expected three numbers in mm, mm and degrees"),
     (("--tote-shift", "far"), "'far': expected three numbers"),
     (("--touches", "5"), "--touches"), (("--touches", "11"), "--touches"),
     (("--touches", "six"), "--touches")],
)  # fmt: skip
def test_what_is_not_said_rightly_is_a_mistake_of_usage(
    tmp_path: Path, words: tuple[str, ...], told: str
) -> None:
    answer = apc("locate-tote", *words, "-o", tmp_path / "tote.json")
    assert answer.code == 2 and told in answer.err and answer.err.count("Error:") == 1
    assert list(tmp_path.iterdir()) == []


def test_an_existing_file_is_kept(stated: Path) -> None:
    before = stated.read_text()
    refused(apc("locate-tote", "-o", stated), 3, "--overwrite")
    assert stated.read_text() == before


@pytest.mark.slow
def test_a_displaced_tote_is_located_and_told(tmp_path: Path) -> None:
    path = tmp_path / "tote.json"
    answer = apc("locate-tote", "--tote-shift", "10,-20,1", "--touches", 7, "--seed", 2, "-o", path, "--json")
    assert answer.code == 0, answer.err
    told, content = json.loads(answer.out), json.loads(path.read_text())
    assert {key: told[key] for key in content} == content
    for name, off in told["truly_off"].items():
        assert abs(off) <= content["error"][name]
    assert told["displacement"]["x"] == pytest.approx(0.01, abs=1e-3)
    assert told["displacement"]["y"] == pytest.approx(-0.02, abs=1e-3)
    assert told["collisions"] == 0 and len(content["touches"]) == 7
