"""The pod from several looks: errors of mounts are told apart from where it stands, as far as they can be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import displaced, yaw_of
from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file
from pickcli.cell.sensors.mounted_camera import MountedCamera, MountError
from pickcli.cell.station import POD
from pickcli.geometry import Array, inverse, pose, rotation_from_vector, rotation_vector
from pickcli.perception.camera_pose import camera_pose
from pickcli.perception.depth_picture import measure_depth
from pickcli.perception.mount_calibration import UNDERSTATED, PodLook, calibrated_mounts, camera_in_pod
from pickcli.perception.pod_fit import CameraFit
from pickcli.perception.rendered_scene import RenderedScene
from pickcli.random_scenes.make_scene import make_scene
from pickcli.scene.scene import CarrierPose, Scene

MOUNT = MountError(0.001, 0.0035)
BINS = "ABCDEFGHIJKL"
SENSORS = ("ensenso", "carmine", "kinect_v2")
CONTENTS = {
    "bin_A": ("crayola_24_ct", "kleenex_tissue_box"),
    "bin_E": ("folgers_classic_roast_coffee",),
    "bin_F": ("dove_beauty_bar", "up_glucose_bottle"),
    "bin_L": ("scotch_duct_tape", "kleenex_paper_towels"),
}
STATED = np.diag(np.repeat([1e-4, 2e-4], 3) ** -2.0)  # information of a drawn look


def drawn_mount(rng: np.random.Generator, mount: MountError) -> Array:
    """An error of a mount at its bounds, in the direction of a draw."""
    shift, turn = (v / np.linalg.norm(v) for v in rng.standard_normal((2, 3)))
    return pose(mount.position * shift, R=rotation_from_vector(mount.angle * turn))


def drawn_looks(
    cell: Cell, rng: np.random.Generator, bins: str = BINS, mount: MountError = MOUNT
) -> tuple[list[PodLook], Array]:
    """Looks with an error at the bounds of the mount and some in each picture, and the pose of the pod."""
    off = drawn_mount(rng, mount)
    T_world_pod = displaced(cell.T_world_pod, *rng.uniform(-1.0, 1.0, 3) * [0.05, 0.05, 0.05])
    camera = replace(cell.cameras["hand"], error=mount)
    looks = []
    for name in bins:
        at = cell.configurations[f"cam_{name}"]
        T = camera_pose(cell.robot, camera, at.q, at.tool_state)
        error = UNDERSTATED * rng.standard_normal(6) / np.sqrt(np.diag(STATED))
        in_picture = pose(error[:3], R=rotation_from_vector(error[3:]))
        fit = CameraFit(inverse(T_world_pod) @ T @ off @ in_picture, STATED)
        looks.append(PodLook(camera, T, fit))
    return looks, T_world_pod


def taken_looks(
    scene: Scene, camera: MountedCamera, bins: str, off: Array, seed: int
) -> tuple[list[PodLook], list[Array]]:
    """Looks whose pictures are rendered with the noise of a sensor, and the error (6,) of each."""
    cell, noise = scene.cell, camera.model.depth
    assert noise is not None
    looks, errors = [], []
    for name in bins:
        at = cell.configurations[f"cam_{name}"]
        T = camera_pose(cell.robot, camera, at.q, at.tool_state)
        rendered = RenderedScene.of(scene, at.q, at.tool_state)
        picture = replace(measure_depth(rendered, camera.model, T @ off, seed), T_world_camera=T)
        fit = camera_in_pod(picture, cell, noise, cell.T_world_pod)
        looks.append(PodLook(camera, T, fit))
        error = inverse(fit.T_pod_camera) @ inverse(scene.T_world_pod) @ T @ off
        errors.append(np.concatenate([error[:3, 3], rotation_vector(error[:3, :3])]))
    return looks, errors


@pytest.mark.parametrize("sensor", SENSORS)
def test_pictures_taken_by_a_camera_that_is_off_leave_the_pod_within_its_bounds(
    cell: Cell, sensor: str
) -> None:
    rng = np.random.default_rng(11)
    camera = replace(cell.cameras["hand"], model=read_sensor(sensor_file(sensor)), error=MOUNT)
    T_world_pod = displaced(cell.T_world_pod, 0.02, -0.03, 0.015)
    scene = make_scene(CONTENTS, cell, seed=3, carriers={POD: CarrierPose(T_world_pod)})
    by_stated = []
    for seed in range(3):
        looks, errors = taken_looks(scene, camera, "AFHL", drawn_mount(rng, MOUNT), seed)
        by_stated += [
            error @ look.at_pod.information @ error for look, error in zip(looks, errors, strict=True)
        ]
        found = calibrated_mounts(looks, cell.T_world_pod)
        off = inverse(found.T_world_pod) @ scene.T_world_pod
        assert found.error.allows(off)
        for point in ([0.0, -0.4, 0.5], [0.0, 0.4, 1.8], [0.4, 0.0, 1.2]):
            assert np.linalg.norm(off[:3, :3] @ point + off[:3, 3] - point) <= found.error_at(np.array(point))
    spread = np.sqrt(np.mean(by_stated) / 6.0)  # of the errors in pictures, in stated standard deviations
    assert spread < 1.5 * UNDERSTATED


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


def test_a_mount_that_is_said_to_be_exact_and_is_not_breaks_the_bounds(cell: Cell) -> None:
    rng = np.random.default_rng(5)
    looks, T_true = drawn_looks(cell, rng)
    exact = replace(looks[0].camera, error=MountError(0.0, 0.0))
    found = calibrated_mounts([replace(look, camera=exact) for look in looks], cell.T_world_pod)
    assert not found.error.allows(inverse(found.T_world_pod) @ T_true)


def test_a_look_that_tells_little_counts_little(cell: Cell) -> None:
    """Each picture counts by its own information."""
    rng = np.random.default_rng(8)
    looks, T_true = drawn_looks(cell, rng, "EFH", MountError(0.0, 0.0))
    fit = looks[0].at_pod
    away = CameraFit(fit.T_pod_camera @ pose((0.02, 0.02, 0.0)), 1e-6 * fit.information)
    found = calibrated_mounts([replace(looks[0], at_pod=away), *looks[1:]], cell.T_world_pod)
    assert found.error.allows(inverse(found.T_world_pod) @ T_true)


def test_several_looks_leave_the_shift_of_the_mount_alone(cell: Cell) -> None:
    rng = np.random.default_rng(6)
    one, _ = drawn_looks(cell, rng, "E")
    alone = calibrated_mounts(one, cell.T_world_pod)
    looks, T_true = drawn_looks(cell, rng)
    found = calibrated_mounts(looks, cell.T_world_pod)
    middle = np.array([0.2, 0.0, 1.2])
    assert found.error_at(middle) < 0.0021 < 0.003 < alone.error_at(middle)
    assert found.error.yaw < MOUNT.angle / 3 < alone.error.yaw
    assert abs(yaw_of(inverse(found.T_world_pod) @ T_true)) < MOUNT.angle / 10


def test_an_exact_mount_leaves_what_pictures_leave(cell: Cell) -> None:
    looks, T_true = drawn_looks(cell, np.random.default_rng(7), mount=MountError(0.0, 0.0))
    found = calibrated_mounts(looks, cell.T_world_pod)
    assert found.error.x < 8e-4 and found.error.y < 8e-4
    assert found.error.allows(inverse(found.T_world_pod) @ T_true)
    np.testing.assert_allclose(found.T_camera_mounted["hand"], np.eye(4), atol=1e-5)
