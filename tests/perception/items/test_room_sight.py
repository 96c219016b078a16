"""The share of a room that is seen, against rays to points of it, and who hides the rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.geometry import pose
from pickcli.perception.camera_pose import camera_pose
from pickcli.perception.items.room_sight import RoomSight, coarse_view, room_sight
from pickcli.perception.rendered_scene import RenderedScene
from pickcli.scene.scene import empty_scene
from support.filled_bins import Filled


def sight(cell: Cell, camera: str, at: str, place: str) -> RoomSight:
    scene, where, mounted = empty_scene(cell), cell.configurations[at], cell.cameras[camera]
    T = camera_pose(cell.robot, mounted, where.q, where.tool_state)
    known = RenderedScene.of(scene, where.q, where.tool_state)
    of = cell.places[place]
    return room_sight(coarse_view(mounted.model.camera, T, known), known, of, scene.T_world_place(of))


@pytest.mark.parametrize("letter", list("ABCDEFGHIJKL"))
def test_a_look_is_into_the_bin_that_it_is_for(cell: Cell, letter: str) -> None:
    shares = {name: sight(cell, "hand", f"cam_{letter}", name).seen for name in cell.pod.bins}
    assert shares.pop(f"bin_{letter}") > 0.75
    assert max(shares.values()) < 0.5


def test_the_robot_is_told_apart_from_walls(cell: Cell) -> None:
    free, covered = (sight(cell, "boom", at, "tote") for at in ("home", "tote_11h"))
    assert free.is_enough and free.fault == ""
    assert free.hidden_by_robot == 0.0
    assert not covered.is_enough
    assert covered.hidden_by_robot > 0.5
    assert "hidden by the robot" in covered.fault
    beside = sight(cell, "hand", "cam_E", "bin_D")
    assert "hidden by walls" in beside.fault and "outside of the picture" in beside.fault


def test_shares_are_those_of_rays(filled: Filled) -> None:
    """Random points of the room, each seen by a camera of one pixel that looks at it."""
    camera, T, room = filled.rgbd.sensor.camera, filled.rgbd.T_world_camera, filled.place.room
    rng = np.random.default_rng(3)
    points = rng.uniform(room.low, room.high, (4000, 3))
    is_inside = (points[:, 2] > room.floor_at(points[:, 0])) & (points[:, 2] < room.ceiling_at(points[:, 0]))
    points = points[is_inside]
    in_camera = (np.linalg.inv(T) @ filled.T_world_place @ np.c_[points, np.ones(len(points))].T).T[:, :3]
    pixels = camera.project(in_camera)
    seen = 0
    for p, (u, v) in zip(in_camera, pixels, strict=True):
        if 0 <= u < camera.width - 1 and 0 <= v < camera.height - 1:
            one = replace(camera, cx=camera.cx - u, cy=camera.cy - v, width=1, height=1)
            depth = filled.known.seen_by(one, T).depth[0, 0]
            seen += not depth < p[2]
    counted = room_sight(
        coarse_view(camera, T, filled.known), filled.known, filled.place, filled.T_world_place
    )
    assert counted.seen == pytest.approx(seen / len(points), abs=0.03)


def test_nothing_is_seen_from_behind(filled: Filled) -> None:
    T = filled.T_world_place @ pose((1.5, 0.0, 0.1), rpy=(0.0, -np.pi / 2, 0.0))
    view = coarse_view(filled.rgbd.sensor.camera, T, filled.known)
    assert room_sight(view, filled.known, filled.place, filled.T_world_place).seen == 0.0
