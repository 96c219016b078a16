"""Depth that the camera of a truck recorded, as a recording of docs/formats/recording.md describes it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.driving.truck_camera import TruckCamera, floor_pose
from pickcli.errors import InputError
from pickcli.geometry import Array, inverse
from pickcli.perception.depth_picture import DepthPicture
from pickcli.perception.recorded_picture import RecordedPicture

CAMERA = "truck"  # name of the camera in recordings


def recorded_look(recording: RecordedPicture, camera: TruckCamera) -> tuple[DepthPicture, Array]:
    """Read a recorded picture of a truck.

    Args:
        recording: The recording; ``at`` is the pose of the truck in the area, x, y in m and yaw in rad.
        camera: The camera of the truck.

    Returns:
        The picture, whose world is the frame of the truck; (3,) m, m, rad where the truck was.

    Raises:
        InputError: It is of another camera or sensor, ``at`` is no pose or the camera is elsewhere there, or
            the depth cannot be used.
    """
    if recording.camera != CAMERA:
        raise InputError(f"{recording.path}: is of camera {recording.camera}, not of {CAMERA}")
    if recording.sensor != camera.model.name:
        raise InputError(
            f"{recording.path}: is of sensor {recording.sensor}, but the area states {camera.model.name}; "
            "state it under camera"
        )
    truck = _pose(recording)
    recording.refuse_elsewhere(floor_pose(truck) @ camera.T_truck_camera)
    taken = recording.depth_picture(replace(camera.model, camera=recording.intrinsics))
    T_truck_camera = inverse(floor_pose(truck)) @ recording.T_world_camera
    return DepthPicture(taken.camera, T_truck_camera, taken.depth), truck


def _pose(recording: RecordedPicture) -> Array:
    try:
        values = [float(word) for word in recording.at.split(",")]
    except ValueError:
        values = []
    if len(values) != 3 or not np.isfinite(values).all():
        raise InputError(
            f"{recording.path}: at is {recording.at!r}; state the pose of the truck there, as 1.5,2,0.1"
        )
    return np.array(values)
