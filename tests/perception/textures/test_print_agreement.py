"""Prints in several looks: which are of one copy, and which are solved together."""

from __future__ import annotations

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.geometry import Array, inverse, pose, rotation_axis_angle, transform_points
from pickcli.perception.textures.joint_pose import PrintSighting
from pickcli.perception.textures.print_agreement import joint_print_poses

CAMERA = PinholeCamera(1451.0, 1451.0, 639.5, 511.5, 1280, 1024)
T_ITEM = pose([0.02, -0.01, 0.03], R=rotation_axis_angle(np.array([1.0, 2.0, 3.0]) / 14.0**0.5, 0.7))
ASIDE = np.radians(20.0)
APART = 0.05
T_COPY = pose([0.15, 0.02, 0.03])


def camera_at(turn: float) -> Array:
    """A camera 0.7 m before the middle, turned about the vertical through it; y is down in its picture."""
    R = rotation_axis_angle(np.array([0.0, 1.0, 0.0]), turn)
    return pose(-0.7 * R[:, 2], R=R)


def sighting(item: Item, T_camera: Array, T_item: Array, n: int = 40) -> PrintSighting:
    rng = np.random.default_rng(n)
    points = np.column_stack([rng.uniform(-0.5, 0.5, (n, 2)), np.full(n, 0.5)]) * item.shape.extents
    T_camera_item = inverse(T_camera) @ T_item
    pixels = CAMERA.project(transform_points(T_camera_item, points))
    return PrintSighting(CAMERA, T_camera_item, points, pixels)


def test_copies_are_told_apart(soap: Item) -> None:
    cameras = [camera_at(turn) for turn in (0.0, ASIDE, -ASIDE)]
    looks = [
        (cameras[0], [sighting(soap, cameras[0], T_ITEM), sighting(soap, cameras[0], T_COPY, 30)]),
        (cameras[1], [sighting(soap, cameras[1], T_COPY, 30), sighting(soap, cameras[1], T_ITEM)]),
        (cameras[2], [sighting(soap, cameras[2], T_ITEM)]),
    ]
    first, second = joint_print_poses(soap, looks, APART)
    assert np.allclose(first.T_world_item, T_ITEM, atol=1e-6)
    assert np.allclose(second.T_world_item, T_COPY, atol=1e-6)


def test_looks_from_one_place_are_no_second_opinion(soap: Item) -> None:
    near = camera_at(0.0) @ pose([0.01, 0.0, 0.0])
    looks = [(T, [sighting(soap, T, T_ITEM)]) for T in (camera_at(0.0), near)]
    assert joint_print_poses(soap, looks, APART) == []


def test_poses_that_are_elsewhere_are_not_put_together(soap: Item) -> None:
    there = T_ITEM @ pose([0.0, 0.0, 0.03])
    looks = [(T, [sighting(soap, T, at)]) for T, at in ((camera_at(0.0), T_ITEM), (camera_at(ASIDE), there))]
    assert joint_print_poses(soap, looks, APART) == []


def test_a_face_that_looks_alike_is_another_one(soap: Item) -> None:
    turned = T_ITEM @ pose(R=rotation_axis_angle(np.array([0.0, 0.0, 1.0]), np.pi))
    looks = [(T, [sighting(soap, T, at)]) for T, at in ((camera_at(0.0), T_ITEM), (camera_at(ASIDE), turned))]
    assert joint_print_poses(soap, looks, APART) == []


def test_nothing_is_said_of_what_no_look_recognised(soap: Item) -> None:
    assert joint_print_poses(soap, [(camera_at(0.0), []), (camera_at(ASIDE), [])], APART) == []
