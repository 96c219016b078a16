"""From where places are looked into: the best configuration, and aslant from both sides."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.pod_tolerance import displaced
from pickcli.cell.sensors.mounted_camera import MountedCamera
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import InputError
from pickcli.perception.camera_pose import camera_pose
from pickcli.perception.items.room_sight import LEAST_SEEN, coarse_view, room_sight
from pickcli.perception.items.unknown_voxels import ASIDE
from pickcli.perception.rendered_scene import RenderedScene
from pickcli.perception.viewpoints import (
    ASLANT,
    further_viewpoints,
    sees_all_bins,
    viewpoint_of,
    viewpoints_of,
)
from pickcli.scene.scene import empty_scene


def test_every_bin_is_looked_into_from_its_own_place(cell: Cell) -> None:
    for name, place in cell.pod.bins.items():
        viewpoint = viewpoint_of(place, cell)
        assert viewpoint.at.name == f"cam_{name.removeprefix('bin_')}"
        assert viewpoint.camera.name == "hand"


@pytest.mark.parametrize("name", ["bin_A", "bin_H", "bin_L"])
def test_cameras_on_the_arm_look_aslant_from_both_sides_too(cell: Cell, name: str) -> None:
    place, scene = cell.pod.bins[name], empty_scene(cell)
    mouth = (cell.T_world_place(place) @ place.access.T_place_mouth)[:3, 3]
    first, *aslant = viewpoints_of(place, cell)
    turns = []
    for each in aslant:
        T = camera_pose(cell.robot, each.camera, each.at.q, each.at.tool_state)
        np.testing.assert_allclose(T, each.T_world_camera, atol=1e-5)
        before, after = (v.T_world_camera[:3, 3] - mouth for v in (first, each))
        assert np.linalg.norm(after) == pytest.approx(np.linalg.norm(before), abs=1e-6)
        turns.append(np.arctan2(np.cross(before, after)[2], before[:2] @ after[:2]))
        known = RenderedScene.of(scene, each.at.q, each.at.tool_state)
        view = coarse_view(each.camera.model.camera, T, known)
        assert room_sight(view, known, place, scene.T_world_place(place)).seen >= LEAST_SEEN
    assert turns == pytest.approx([ASLANT, -ASLANT])


def test_further_looks_are_from_elsewhere_at_the_same_distance(cell: Cell) -> None:
    """Each bin has at least three; all are 5 cm and more from where it was looked into before."""
    for place in cell.pod.bins.values():
        first, further = viewpoints_of(place, cell), further_viewpoints(place, empty_scene(cell))
        mouth = (cell.T_world_place(place) @ place.access.T_place_mouth)[:3, 3]
        eyes = [each.T_world_camera[:3, 3] for each in (*first, *further)]
        assert len(further) >= 3
        assert len({each.at.name for each in (*first, *further)}) == len(eyes)
        away = [float(np.linalg.norm(eye - mouth)) for eye in eyes]
        assert away == pytest.approx([away[0]] * len(eyes), abs=1e-6)
        for each in further:
            T = camera_pose(cell.robot, each.camera, each.at.q, each.at.tool_state)
            np.testing.assert_allclose(T, each.T_world_camera, atol=1e-4)
            off = [np.linalg.norm(T[:3, 3] - other.T_world_camera[:3, 3]) for other in first]
            assert min(off) > ASIDE


def test_further_looks_see_enough_of_a_place_where_it_is_believed_to_be(cell: Cell) -> None:
    free = cell.pod.displacement
    for sign in (1.0, -1.0):
        T_world_pod = displaced(cell.T_world_pod, free.x, sign * free.y, sign * free.yaw)
        scene = replace(empty_scene(cell), T_world_pod=T_world_pod)
        for place in (cell.pod.bins["bin_G"], cell.pod.bins["bin_D"]):
            for each in further_viewpoints(place, scene):
                known = RenderedScene.of(scene, each.at.q, each.at.tool_state)
                view = coarse_view(each.camera.model.camera, each.T_world_camera, known)
                assert room_sight(view, known, place, scene.T_world_place(place)).seen > LEAST_SEEN + 0.01


def test_the_arm_is_clear_where_it_looks_from_wherever_the_pod_stands(cell: Cell) -> None:
    rng, free = np.random.default_rng(3), cell.pod.displacement
    model, most = CollisionModel(cell), np.array([free.x, free.y, free.yaw])
    viewpoints = [
        each
        for name in ("bin_A", "bin_F", "bin_K")
        for place in (cell.pod.bins[name],)
        for each in (*viewpoints_of(place, cell), *further_viewpoints(place, empty_scene(cell)))
    ]
    for _ in range(20):
        T_world_pod = displaced(cell.T_world_pod, *(most * rng.choice([-1.0, 1.0], 3)))
        checker = SceneChecker(
            model, replace(empty_scene(cell), T_world_pod=T_world_pod), viewpoints[0].at.tool_state
        )
        assert all(checker.is_valid(each.at.q) for each in viewpoints)


def test_a_camera_that_the_arm_does_not_move_looks_from_where_it_is(cell: Cell) -> None:
    place, hand = cell.pod.bins["bin_E"], cell.cameras["hand"]
    T = viewpoint_of(place, cell).T_world_camera
    fixed = MountedCamera("waist", hand.model, None, T, hand.error)
    (only,) = viewpoints_of(place, replace(cell, cameras={"waist": fixed}))
    assert only.camera is fixed
    assert further_viewpoints(place, empty_scene(replace(cell, cameras={"waist": fixed}))) == ()


def test_a_cell_without_cameras_cannot_be_seen_by_them(cell: Cell) -> None:
    blind = replace(cell, cameras={})
    with pytest.raises(InputError, match=r"sees half of its room .*; state one \(docs/formats/cell.md\)$"):
        viewpoint_of(cell.pod.bins["bin_A"], blind)


def test_all_bins_are_seen_or_not(cell: Cell) -> None:
    assert sees_all_bins(cell)
    assert not sees_all_bins(replace(cell, cameras={}))
    but_one = {name: at for name, at in cell.configurations.items() if name != "cam_E"}
    assert not sees_all_bins(replace(cell, configurations=but_one))


def test_a_cell_without_bins_is_not_seen_into() -> None:
    assert not sees_all_bins(load_cell("ur5e_crates"))
