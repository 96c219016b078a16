"""Unknown space in scene files: it comes back, counts in the hash, and mistakes in it are told."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.station import UNKNOWN
from pickcli.geometry import pose, transform_points
from pickcli.scene.scene import Scene
from pickcli.scene.scene_file import read_scene, scene_hash, write_scene
from pickcli.scene.unknown_space import UnknownSpace
from support.scene_files import make_scene

Refused = Callable[[Callable[[], object]], str]

BOXES = np.array([[[0.2, -0.1, 0.0], [0.4, 0.1, 0.05]], [[0.3, -0.1, 0.05], [0.4, 0.1, 0.1]]])


@pytest.fixture
def scene(cell: Cell) -> Scene:
    T = cell.T_world_place(cell.pod.bins["bin_L"]) @ pose((0.001, 0.002, 0.0), rpy=(0.0, 0.0, 0.003))
    return replace(make_scene(cell), unknown=(UnknownSpace("bin_L", T, BOXES),))


def test_it_comes_back_and_makes_another_scene(scene: Scene, tmp_path: Path) -> None:
    path = tmp_path / "scene.json"
    write_scene(scene, path)
    back = read_scene(path)
    (space,) = back.unknown
    np.testing.assert_allclose(space.boxes, BOXES)
    np.testing.assert_allclose(space.T_world_place, scene.unknown[0].T_world_place, atol=1e-12)
    assert scene_hash(back) == scene_hash(scene)
    smaller = replace(scene, unknown=(replace(space, boxes=BOXES[:1]),))
    assert len({scene_hash(each) for each in (scene, smaller, replace(scene, unknown=()))}) == 3


def test_what_is_not_recognised_comes_back_and_makes_another_scene(scene: Scene, tmp_path: Path) -> None:
    """Also where nothing else of the place is unknown."""
    path, (space,) = tmp_path / "scene.json", scene.unknown
    for boxes in (BOXES, np.zeros((0, 2, 3))):
        with_it = replace(scene, unknown=(replace(space, boxes=boxes, unrecognised=BOXES[1:]),))
        write_scene(with_it, path, replace=True)
        back = read_scene(path)
        np.testing.assert_allclose(back.unknown[0].unrecognised, BOXES[1:])
        assert len(back.unknown[0].boxes) == len(boxes)
        assert scene_hash(back) == scene_hash(with_it) != scene_hash(scene)
        assert [body.name for body in back.unrecognised_in("bin_L")] == ["unrecognised_bin_L_0"]
        assert not back.unrecognised_in("bin_C")


def test_its_bodies_fill_its_boxes(scene: Scene) -> None:
    (space,), (carrier,) = scene.unknown, (each for each in scene.posed_carriers if each.name == UNKNOWN)
    assert len({body.name for body, _ in scene.standing}) == len(scene.standing)
    assert carrier.grown == carrier.bodies
    for body, (low, high) in zip(carrier.bodies, space.boxes, strict=True):
        corners = transform_points(
            body.T_parent_shape, np.array([-1.0, 1.0])[:, None] * body.shape.extents / 2
        )
        expected = transform_points(carrier.T_world_carrier @ space.T_world_place, np.array([low, high]))
        np.testing.assert_allclose(corners, expected, atol=1e-12)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"place": "bin_Z"}, "unknown place 'bin_Z'"),
        ({"boxes": []}, "has no boxes"),
        ({"unrecognised": [[[0.2, 0.0, 0.0], [0.1, 0.1, 0.1]]]}, "must be below the second"),
        ({"unrecognised": [[[0.2, 0.0], [0.1, 0.1, 0.1]]]}, "unrecognised"),
        ({"boxes": [[[0.2, 0.0, 0.0], [0.1, 0.1, 0.1]]]}, "must be below the second"),
        ({"boxes": [[[0.2, 0.0], [0.1, 0.1, 0.1]]]}, "boxes"),
        ({"quaternion": [0.0, 0.0, 0.0, 2.0]}, "expected a length of 1"),
        ({"size": 3}, "size"),
    ],
)
def test_mistakes_are_told(
    scene: Scene, tmp_path: Path, refused: Refused, change: dict[str, Any], told: str
) -> None:
    path = tmp_path / "scene.json"
    write_scene(scene, path)
    content = json.loads(path.read_text())
    content["unknown"][0] |= change
    path.write_text(json.dumps(content))
    assert told in refused(lambda: read_scene(path))


def test_a_place_stands_once(scene: Scene, tmp_path: Path, refused: Refused) -> None:
    path = tmp_path / "scene.json"
    write_scene(replace(scene, unknown=scene.unknown * 2), path)
    assert "bin_L stands twice" in refused(lambda: read_scene(path))
