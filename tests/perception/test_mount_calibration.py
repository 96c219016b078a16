"""The pod from several looks: errors of mounts are told apart from where it stands, as far as they can be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import displaced, yaw_of
from pickcli.cell.sensors.mounted_camera import MountError
from pickcli.geometry import Array, inverse, pose, rotation_angle, rotation_axis_angle
from pickcli.perception.camera_pose import camera_pose
from pickcli.perception.depth_picture import measure_depth
from pickcli.perception.mount_calibration import SPREAD, PodLook, calibrated_mounts, camera_in_pod
from pickcli.perception.rendered_scene import RenderedScene
from support.scene_files import make_scene

MOUNT = MountError(0.001, 0.0035)
BINS = "ABCDEFGHIJKL"


def drawn_looks(
    cell: Cell, rng: np.random.Generator, bins: str = BINS, mount: MountError = MOUNT
) -> tuple[list[PodLook], Array]:
    """Looks with an error at the bounds of the mount and some in each picture, and the pose of the pod."""
    shift, turn = (v / np.linalg.norm(v) for v in rng.standard_normal((2, 3)))
    off = pose(mount.position * shift, R=rotation_axis_angle(turn, mount.angle))
    T_world_pod = displaced(cell.T_world_pod, *rng.uniform(-1.0, 1.0, 3) * [0.05, 0.05, 0.05])
    camera = replace(cell.cameras["hand"], error=mount)
    looks = []
    for name in bins:
        at = cell.configurations[f"cam_{name}"]
        T = camera_pose(cell.robot, camera, at.q, at.tool_state)
        error = SPREAD * rng.standard_normal(6)
        angle = float(np.linalg.norm(error[3:]))
        in_picture = pose(error[:3], R=rotation_axis_angle(error[3:] / angle, angle))
        looks.append(PodLook(camera, T, inverse(T_world_pod) @ T @ off @ in_picture))
    return looks, T_world_pod


@pytest.mark.parametrize("bins", [BINS, "A", "FL"])
def test_bounds_hold_the_pod_whatever_the_error_of_the_mount(cell: Cell, bins: str) -> None:
    rng = np.random.default_rng(5)
    for _ in range(60):
        looks, T_true = drawn_looks(cell, rng, bins)
        found = calibrated_mounts(looks, cell.T_world_pod)
        off = inverse(found.T_world_pod) @ T_true
        assert off[2, 3] == pytest.approx(0.0, abs=1e-12)
        assert found.error.allows(off)
        point = rng.uniform([0.0, -0.4, 0.5], [0.4, 0.4, 1.8])
        assert np.linalg.norm(off[:3, :3] @ point + off[:3, 3] - point) <= found.error_at(point)


def test_several_looks_leave_the_shift_of_the_mount_alone(cell: Cell) -> None:
    rng = np.random.default_rng(6)
    one, _ = drawn_looks(cell, rng, "E")
    alone = calibrated_mounts(one, cell.T_world_pod)
    looks, T_true = drawn_looks(cell, rng)
    found = calibrated_mounts(looks, cell.T_world_pod)
    middle = np.array([0.2, 0.0, 1.2])
    assert found.error_at(middle) < 0.0018 < 0.003 < alone.error_at(middle)
    assert found.error.yaw < MOUNT.angle / 5 < alone.error.yaw
    assert abs(yaw_of(inverse(found.T_world_pod) @ T_true)) < MOUNT.angle / 20


def test_an_exact_mount_leaves_what_pictures_leave(cell: Cell) -> None:
    looks, T_true = drawn_looks(cell, np.random.default_rng(7), mount=MountError(0.0, 0.0))
    found = calibrated_mounts(looks, cell.T_world_pod)
    assert found.error.x < 3e-4 and found.error.y < 3e-4
    assert found.error.allows(inverse(found.T_world_pod) @ T_true)
    np.testing.assert_allclose(found.T_camera_mounted["hand"], np.eye(4), atol=1e-5)


def test_a_camera_is_found_relative_to_the_pod_in_its_picture(cell: Cell) -> None:
    hand, scene, at = cell.cameras["hand"], make_scene(cell), cell.configurations["cam_E"]
    assert hand.model.depth is not None
    T = camera_pose(cell.robot, hand, at.q, at.tool_state)
    T_true = T @ pose((0.0006, -0.0006, 0.0005), R=rotation_axis_angle([0.6, 0.0, 0.8], 0.0035))
    rendered = RenderedScene.of(scene, at.q, at.tool_state)
    picture = replace(measure_depth(rendered, hand.model, T_true, seed=1), T_world_camera=T)
    T_pod_camera = camera_in_pod(picture, cell, hand.model.depth, cell.T_world_pod)
    off = inverse(T_pod_camera) @ inverse(scene.T_world_pod) @ T_true
    assert np.linalg.norm(off[:3, 3]) < 4e-4 and rotation_angle(off[:3, :3]) < 8e-4
