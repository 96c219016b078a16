"""Scenes in which the tote does not stand where the cell says."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from pickcli.cell.cell_file import load_cell
from pickcli.cell.pod_tolerance import Displacement, displaced
from pickcli.geometry import Array, inverse, pose, transform_points
from pickcli.scene.scene import TOTE, PosedCarrier, Scene, empty_scene, tote_pose
from pickcli.scene.scene_file import read_scene, scene_hash, write_scene

CELL = load_cell("apc2016_delft")
PLACE = CELL.places[TOTE]
T_NOMINAL = CELL.T_world_place(PLACE)
MOVED = T_NOMINAL @ pose((0.02, -0.01, 0.001), rpy=(0.0, 0.0, 0.04))
ERROR = Displacement(0.002, 0.001, 0.02)


def scene(T: Array = MOVED, error: Displacement = ERROR) -> Scene:
    return replace(empty_scene(CELL), carriers={TOTE: tote_pose(CELL, T, error)})


def tote_of(of: Scene) -> PosedCarrier:
    return next(each for each in of.posed_carriers if each.name == TOTE)


def corners(carrier: PosedCarrier, grown: bool = False) -> dict[str, Array]:
    """Corners (8, 3) of each body in the world."""
    signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T
    return {
        body.name: transform_points(
            carrier.T_world_carrier @ body.T_parent_shape, signs * body.shape.extents / 2
        )
        for body in (carrier.grown if grown else carrier.bodies)
    }


def test_it_is_written_as_the_pose_of_its_place_and_read_alike(tmp_path: Path) -> None:
    write_scene(scene(), tmp_path / "scene.json")
    again = read_scene(tmp_path / "scene.json", CELL)
    assert scene_hash(again) == scene_hash(scene()) != scene_hash(empty_scene(CELL))
    stated = json.loads((tmp_path / "scene.json").read_text())["places"][TOTE]
    assert_allclose(stated["position"], MOVED[:3, 3], atol=1e-12)
    assert again.carriers[TOTE].error == ERROR
    assert_allclose(again.T_world_place(PLACE), MOVED, atol=1e-9)


@pytest.mark.parametrize("error", [Displacement(), ERROR])
def test_its_solids_move_with_it_whether_or_not_it_is_uncertain(error: Displacement) -> None:
    at, nominal = corners(tote_of(scene(error=error))), corners(tote_of(empty_scene(CELL)))
    move = MOVED @ inverse(T_NOMINAL)
    for name, points in nominal.items():
        assert_allclose(at[name], transform_points(move, points), atol=1e-12)


def test_its_error_turns_it_about_its_own_middle() -> None:
    """Not about the origin of the world, 1.2 m away, which would move it by 24 mm."""
    swept, exact = corners(tote_of(scene()), grown=True), corners(tote_of(scene()))
    half = float(np.hypot(*PLACE.room.size[:2])) / 2 + 0.06
    for name, points in swept.items():
        grown = np.abs(np.sort(points, axis=0) - np.sort(exact[name], axis=0)).max()
        assert 0.0 < grown < 2 * (ERROR.bound(half) + 1e-9)
    for x, y, yaw in ((0.002, 0.001, 0.02), (-0.002, 0.001, -0.02)):
        true = corners(tote_of(scene(displaced(MOVED, x, y, yaw), Displacement())))
        T_tote_world = inverse(MOVED)
        for name, points in true.items():
            inside = transform_points(T_tote_world, points)
            box = transform_points(T_tote_world, swept[name])
            assert (inside >= box.min(axis=0) - 1e-9).all() and (inside <= box.max(axis=0) + 1e-9).all()
