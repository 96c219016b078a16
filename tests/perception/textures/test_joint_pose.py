"""One pose by the print in several pictures, against poses that are known."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.geometry import Array, inverse, pose, rotation_angle, rotation_axis_angle, transform_points
from pickcli.perception.textures.joint_pose import PrintSighting, joint_pose

CAMERA = PinholeCamera(1451.0, 1451.0, 639.5, 511.5, 1280, 1024)
T_ITEM = pose([0.02, -0.01, 0.03], R=rotation_axis_angle(np.array([1.0, 2.0, 3.0]) / 14.0**0.5, 0.7))
ASIDE = np.radians(20.0)
OFF_PX = 0.3


def camera_at(turn: float) -> Array:
    """A camera 0.7 m before the middle, turned about the vertical through it; y is down in its picture."""
    R = rotation_axis_angle(np.array([0.0, 1.0, 0.0]), turn)
    return pose(-0.7 * R[:, 2], R=R)


def sighting(T_camera: Array, rng: np.random.Generator, n: int = 80, off_px: float = OFF_PX) -> PrintSighting:
    """Matches on a flat face, and a pose that is off by 5 mm along the ray."""
    points = np.column_stack([rng.uniform(-0.06, 0.06, (n, 2)), np.full(n, 0.02)])
    T_camera_item = inverse(T_camera) @ T_ITEM
    pixels = CAMERA.project(transform_points(T_camera_item, points)) + rng.normal(0.0, off_px, (n, 2))
    return PrintSighting(CAMERA, pose([0.0, 0.0, 0.005]) @ T_camera_item, points, pixels)


def seen(turns: list[float], seed: int = 1, off_px: float = OFF_PX) -> list[tuple[Array, PrintSighting]]:
    rng = np.random.default_rng(seed)
    return [(camera_at(turn), sighting(camera_at(turn), rng, off_px=off_px)) for turn in turns]


def test_exact_matches_give_the_pose() -> None:
    joint = joint_pose(seen([0.0, ASIDE], off_px=0.0))
    assert np.allclose(joint.T_world_item, T_ITEM, atol=1e-9)
    assert joint.counted == pytest.approx(1.0)


def test_pictures_from_two_places_tell_what_is_along_the_rays() -> None:
    off = [
        np.linalg.norm(joint_pose(seen([0.0, ASIDE], k)).T_world_item[:3, 3] - T_ITEM[:3, 3])
        for k in range(20)
    ]
    assert max(off) < 4e-4
    one = [joint_pose(seen([0.0], k)).T_world_item[:3, 3] - T_ITEM[:3, 3] for k in range(20)]
    assert np.median(np.abs(one), axis=0)[2] > 2.0 * np.median(np.abs(one), axis=0)[:2].max()


def test_the_covariance_is_that_of_errors_by_matches(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("_OF_LOOK", "_OF_ALL"):
        monkeypatch.setattr(f"pickcli.perception.textures.joint_pose.{name}", np.zeros((6, 6)))
    solved = [joint_pose(seen([0.0, ASIDE], k)) for k in range(200)]
    shifts = np.array([(inverse(T_ITEM) @ each.T_world_item)[:3, 3] for each in solved])
    stated = np.mean([np.diag(each.covariance)[:3] for each in solved], axis=0)
    assert np.allclose(shifts.std(axis=0), np.sqrt(stated), rtol=0.25)


def test_what_a_whole_picture_is_off_counts_besides() -> None:
    joint = joint_pose(seen([0.0, ASIDE], off_px=0.0))
    assert np.sqrt(np.linalg.eigvalsh(joint.covariance[:3, :3])[0]) > 1e-4
    assert np.degrees(np.sqrt(np.linalg.eigvalsh(joint.covariance[3:, 3:])[-1])) > 0.1


def test_matches_that_are_elsewhere_count_little() -> None:
    looks = seen([0.0, ASIDE])
    T, first = looks[0]
    pixels = first.pixels.copy()
    pixels[:15] += 40.0
    joint = joint_pose([(T, PrintSighting(CAMERA, first.T_camera_item, first.points, pixels)), looks[1]])
    assert np.linalg.norm(joint.T_world_item[:3, 3] - T_ITEM[:3, 3]) < 5e-4
    assert rotation_angle(joint.T_world_item[:3, :3].T @ T_ITEM[:3, :3]) < np.radians(0.3)
    assert joint.counted < 0.95
