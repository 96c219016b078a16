"""Scenes that say where places of a cell's own stand."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from numpy.testing import assert_allclose

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.pod_tolerance import Displacement
from pickcli.errors import InputError
from pickcli.geometry import pose
from pickcli.scene.scene import CarrierPose, PlacedItem, PoseNoise, Scene
from pickcli.scene.scene_file import read_scene, scene_hash, write_scene
from support.cell_copies import CellCopy
from support.place_cells import BENCH, CRATES, with_places

BAR = "dove_beauty_bar"
HERE = {"position": [0, 0, 0]}
LEANING = HERE | {"quaternion": [0.0998, 0, 0, 0.995]}
MOVED = pose((-0.88, -0.6, 0.58), rpy=(0.0, 0.0, 0.1))


@pytest.fixture
def own(cell_copy: CellCopy) -> Cell:
    return with_places(cell_copy, CRATES, BENCH).load()


@pytest.fixture
def scene(own: Cell) -> Scene:
    """A bar in the left crate, which stands elsewhere than the cell says."""
    at = CarrierPose(MOVED, Displacement(0.001, 0.002, 0.003))
    empty = Scene(own, own.T_world_pod, (), PoseNoise(), carriers={"crate_left": at})
    item, place = own.item(BAR), own.places["crate_left"]
    T = empty.T_world_place(place) @ pose((0.0, 0.0, float(item.shape.extents[2]) / 2))
    return replace(empty, items=(PlacedItem(BAR, item, "crate_left", T),))


def test_it_is_written_and_read_alike(scene: Scene, tmp_path: Path) -> None:
    write_scene(scene, tmp_path / "scene.json")
    again = read_scene(tmp_path / "scene.json", scene.cell)
    assert scene_hash(again) == scene_hash(scene)
    assert_allclose(again.T_world_place(scene.cell.places["crate_left"]), MOVED, atol=1e-9)
    assert again.carriers["crate_left"].error == Displacement(0.001, 0.002, 0.003)
    right = scene.cell.places["crate_right"]
    assert_allclose(again.T_world_place(right), scene.cell.T_world_place(right))


def test_its_hash_follows_pose_and_error(scene: Scene) -> None:
    others = [CarrierPose(MOVED), CarrierPose(pose((-0.88, -0.61, 0.58)), Displacement(0.001, 0.002, 0.003))]
    hashes = {scene_hash(replace(scene, carriers={"crate_left": at})) for at in others}
    assert len(hashes | {scene_hash(scene)}) == 3


def test_solids_stand_where_the_scene_says_and_are_grown_by_its_error(scene: Scene) -> None:
    (crate,) = (each for each in scene.posed_carriers if each.name == "crate_left")
    assert_allclose(crate.T_world_carrier, MOVED)
    for body, grown in zip(crate.bodies, crate.grown, strict=True):
        assert (grown.shape.extents - body.shape.extents >= [0.002, 0.004, 0.0]).all()
    (right,) = (each for each in scene.posed_carriers if each.name == "crate_right")
    assert right.grown == right.bodies


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"places": {"crate_lft": HERE | {"quaternion": [0, 0, 0, 1]}}}, "did you mean 'crate_left'"),
        ({"places": {"crate_left": HERE | {"quaternion": [0, 0, 0, 2]}}}, "expected a length of 1"),
        ({"places": {"crate_left": HERE}}, "places.crate_left.quaternion"),
        ({"places": {"crate_left": LEANING}}, "leans by 11 degrees; it stands"),
        ({"T_world_pod": HERE | {"quaternion": [1, 0, 0, 0]}}, "leans by 180 degrees"),
        ({"T_world_pod": None}, "T_world_pod"),
    ],
)  # fmt: skip
def test_mistakes_are_told(scene: Scene, tmp_path: Path, change: dict[str, object], told: str) -> None:
    path = tmp_path / "scene.json"
    write_scene(replace(scene, items=()), path)
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(InputError, match=told) as caught:
        read_scene(path, scene.cell)
    assert str(caught.value).count("\n") == 0


def test_an_item_that_stands_in_a_moved_wall_is_found(scene: Scene, tmp_path: Path) -> None:
    shifted = scene.moved(replace(scene.items[0], T_world_item=MOVED @ pose((0.15, 0.0, 0.02))))
    write_scene(shifted, tmp_path / "scene.json")
    with pytest.raises(InputError, match="deep in crate_left_wall_far"):
        read_scene(tmp_path / "scene.json", scene.cell)


def test_an_item_that_lies_beside_what_is_open_above_is_told_one_that_falls_into_it_is_not(
    scene: Scene, tmp_path: Path
) -> None:
    path, (bar,) = tmp_path / "scene.json", scene.items
    for by, is_told in (((0.0, 0.0, 0.5), False), ((0.6, 0.0, 0.0), True)):
        write_scene(
            replace(scene, items=(replace(bar, T_world_item=pose(by) @ bar.T_world_item),)), path, True
        )
        if is_told:
            with pytest.raises(
                InputError, match=f"items\\[0\\].position: {BAR} is 0.[34].* m away from crate_left"
            ):
                read_scene(path, scene.cell)
        else:
            read_scene(path, scene.cell)


def test_the_pod_of_a_cell_without_one_is_refused(tmp_path: Path) -> None:
    cell, path = load_cell("ur5e_crates"), tmp_path / "scene.json"
    write_scene(Scene(cell, cell.T_world_pod, (), PoseNoise()), path)
    at = {"T_world_pod": HERE | {"quaternion": [0, 0, 0, 1]}}
    path.write_text(json.dumps(json.loads(path.read_text()) | at))
    with pytest.raises(InputError, match="T_world_pod: cell ur5e_crates has no pod; leave it out"):
        read_scene(path, cell)


def test_a_measured_pose_may_lean_a_little(scene: Scene, tmp_path: Path) -> None:
    leaning = CarrierPose(pose((-0.88, -0.6, 0.58), rpy=(0.09, 0.0, 0.1)))
    write_scene(replace(scene, items=(), carriers={"crate_left": leaning}), tmp_path / "scene.json")
    read_scene(tmp_path / "scene.json", scene.cell)
