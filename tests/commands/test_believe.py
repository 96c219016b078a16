"""``apc believe``: from what was perceived to a scene that plans are made in, or one message why not."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.scene.scene_file import read_scene
from support.command_line import ITEM, Made, apc


@pytest.fixture(scope="module")
def perceived(made: Made, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("believe") / "perceived.json"
    answer = apc("perceive", "--scene", made.scene, "--camera", "hand", "--at", "cam_C", "-o", path)
    assert answer.code == 0, answer.err
    return path


def test_the_scene_holds_the_truth_within_its_bounds(
    perceived: Path, made: Made, cell: Cell, tmp_path: Path
) -> None:
    path = tmp_path / "believed.json"
    answer = apc("believe", perceived, "--empty", "tote", "-o", path)
    assert answer.code == 0, answer.err
    true, believed = read_scene(made.scene, cell), read_scene(path, cell)
    assert ITEM in {placed.id for placed in believed.items}
    for placed in believed.items:
        off = placed.T_world_item[:3, 3] - true.find(placed.id).T_world_item[:3, 3]
        assert np.linalg.norm(off) < believed.noise_of(placed).position
    assert {space.place for space in believed.unknown} == set(cell.places) - {"tote"}
    again = tmp_path / "again.json"
    told = json.loads(apc("believe", perceived, "--empty", "tote", "-o", again, "--json").out)
    assert told["items"] == [placed.id for placed in believed.items]
    assert again.read_bytes() == path.read_bytes()
    plan = apc("plan-pick", "--scene", path, "--bin", "bin_C", "--item", ITEM, "-o", tmp_path / "plan.json")
    assert plan.code in (0, 5), plan.err  # whether there is one depends on the bounds


@pytest.mark.parametrize(
    ("argv", "code", "told"),
    [
        (("-o", "a.json", "--empty", "bin_Z"), 3, "bin_Z"),
        (("-o", "a.png"), 3, "is written as .json"),
        ((), 2, "-o"),
        (("-o", "a.json", "--cell", "apc2016_kth_picking"), 3, "apc2016_delft"),
    ],
)
def test_mistakes_are_told(
    perceived: Path, tmp_path: Path, argv: tuple[str, ...], code: int, told: str
) -> None:
    words = [str(tmp_path / word) if word.endswith((".png", ".json")) else word for word in argv]
    answer = apc("believe", perceived, *words)
    assert answer.code == code, answer.err
    assert told in answer.err
    assert not list(tmp_path.iterdir())


def test_other_files_are_refused(made: Made, tmp_path: Path) -> None:
    answer = apc("believe", made.scene, "-o", tmp_path / "a.json")
    assert answer.code == 3
    assert "a file of perceived items is expected" in answer.err
