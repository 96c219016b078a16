"""Where the pod stands, from all looks at it: hand-eye calibration with the pod as its target.

What a picture shows relative to the pod in it is not off by the error of the camera's mount. That error is
the same in all looks of a camera, and the pod stands upright on the floor, so several looks tell both apart
but for what moves the pod in all of them alike (Tsai and Lenz 1989 calibrate so with a printed target).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import Displacement, displaced
from pickcli.cell.sensors.mounted_camera import MountedCamera
from pickcli.cell.sensors.sensor_model import DepthModel
from pickcli.geometry import Array, inverse, pose, rotation_from_vector, rotation_vector
from pickcli.perception.depth_picture import DepthPicture
from pickcli.perception.pod_fit import CameraFit, PodFitter, ThinnedPicture
from pickcli.perception.pod_pose import FINE, NARROW, locate_pod

# Standard deviations of a camera's pose relative to the pod in one picture, over those by the information of
# its fit, as neighbouring pixels err alike: root mean square of six directions in 48 pictures, of the sensor
# that needs most (Carmine 2.0, Kinect v2 1.5, RealSense F200 1.3, Ensenso 1.0).
UNDERSTATED = 2.0
FACTOR = 3.4  # of standard deviations: in three dimensions 99 of 100 are within
LEAST_MOUNT = 1e-6  # m and rad: mounts are exact within
_CAMERA_STEPS, _STEPS = 8, 4
_UNMOVED = np.zeros(3)


@dataclass(frozen=True, eq=False)
class PodLook:
    """One look at the pod.

    Attributes:
        camera: The camera.
        T_world_camera: (4, 4) its stated pose.
        at_pod: Where it is relative to the pod, by its picture.
    """

    camera: MountedCamera
    T_world_camera: Array
    at_pod: CameraFit


def camera_in_pod(picture: DepthPicture, cell: Cell, noise: DepthModel, T_world_guess: Array) -> CameraFit:
    """Find the pose of a camera relative to the pod in its picture, in all six directions.

    Args:
        picture: The picture, with the stated pose of its camera.
        cell: A cell with a pod.
        noise: How the sensor measures depth.
        T_world_guess: (4, 4) where the pod may stand, within its tolerance.

    Returns:
        The fit.

    Raises:
        InputError: The pod cannot be located in it.
    """
    T_world_pod = locate_pod(picture, cell, noise, T_world_guess=T_world_guess).T_world_pod
    thinned = ThinnedPicture.of(picture, noise, FINE)
    return PodFitter.of(cell, T_world_pod).camera_fitted(thinned, _UNMOVED, NARROW, _CAMERA_STEPS)


@dataclass(frozen=True, eq=False)
class MountCalibration:
    """The pod as several looks show it, and errors of mounts.

    Attributes:
        T_world_pod: (4, 4) its pose.
        by_mounts: (C, 3, 6) motion of the pod in its own frame, x, y and yaw, by errors of the mount of each
            camera: 3 shifts in m, and 3 turns in rad.
        mounts: (C, 2) bounds of these errors, m and rad.
        covariance: (3, 3) of x, y and yaw by what pictures leave open.
        T_camera_mounted: By camera, (4, 4) pose of the true mount in the frame of the stated one, as far as
            looks tell.
    """

    T_world_pod: Array
    by_mounts: Array
    mounts: Array
    covariance: Array
    T_camera_mounted: dict[str, Array]

    @property
    def error(self) -> Displacement:
        """Bounds of the true pod's pose in the frame of this one."""
        x, y, yaw = (self._bound(row[None]) for row in np.eye(3))
        return Displacement(x, y, yaw)

    def error_at(self, point: Array) -> float:
        """Bound how far a point of the pod is off, which is less than x, y and yaw make possible together.

        Args:
            point: (3,) m, in the frame of the pod.

        Returns:
            m.
        """
        x, y, _ = point
        return self._bound(np.array([[1.0, 0.0, -y], [0.0, 1.0, x]]))

    def _bound(self, rows: Array) -> float:
        """Of the motion of something, rows (M, 3) of which tell how the pod moves it."""
        off = FACTOR * float(np.sqrt(np.linalg.norm(rows @ self.covariance @ rows.T, 2)))
        for by_mount, (position, angle) in zip(self.by_mounts, self.mounts, strict=True):
            off += float(position * np.linalg.norm(rows @ by_mount[:, :3], 2))
            off += float(angle * np.linalg.norm(rows @ by_mount[:, 3:], 2))
        return off


def calibrated_mounts(looks: Sequence[PodLook], T_world_guess: Array) -> MountCalibration:
    """Estimate the pose of the pod from several looks, by least squares.

    Errors of mounts are as if anywhere within their bounds alike (of a point in a ball of radius 1 each
    coordinate has a variance of 1/5): what no look tells stays as stated.

    Args:
        looks: At least one look.
        T_world_guess: (4, 4) where the pod may stand.

    Returns:
        The estimate. Its bounds hold all errors of mounts within theirs.
    """
    cameras = {look.camera.name: look.camera for look in looks}
    mounts = np.array([[each.error.position, each.error.angle] for each in cameras.values()])
    first = {name: 3 + 6 * k for k, name in enumerate(cameras)}
    prior = np.concatenate([np.zeros(3), np.repeat(5.0 * np.maximum(mounts, LEAST_MOUNT) ** -2.0, 3)])
    T_world_pod, off = T_world_guess, np.zeros(len(prior))
    for _ in range(_STEPS):
        told, gradient = np.zeros((len(prior), len(prior))), prior * off
        for look in looks:
            own = slice(first[look.camera.name], first[look.camera.name] + 6)
            T_pod_camera = look.at_pod.T_pod_camera
            seen = inverse(look.T_world_camera @ _moved(off[own])) @ T_world_pod @ T_pod_camera
            J = np.zeros((6, len(prior)))
            J[:, :3] = _adjoint(inverse(T_pod_camera))[:, [0, 1, 5]]
            J[:, own] = -np.eye(6)
            weighted = J.T @ look.at_pod.information / UNDERSTATED**2
            told += weighted @ J
            gradient += weighted @ np.concatenate([seen[:3, 3], rotation_vector(seen[:3, :3])])
        inverse_information = np.linalg.inv(told + np.diag(prior))
        step = -inverse_information @ gradient
        T_world_pod = displaced(T_world_pod, *step[:3])
        off[3:] += step[3:]
    by_prior = -(inverse_information * prior)[:3, 3:]
    return MountCalibration(
        T_world_pod,
        by_prior.reshape(3, len(cameras), 6).swapaxes(0, 1),
        mounts,
        (inverse_information @ told @ inverse_information)[:3, :3],
        {name: _moved(off[at : at + 6]) for name, at in first.items()},
    )


def _moved(off: Array) -> Array:
    """(4, 4) a shift and a turn (6,)."""
    return pose(off[:3], R=rotation_from_vector(off[3:]))


def _adjoint(T: Array) -> Array:
    """(6, 6) shifts and turns of a frame as those of one that is fixed at a pose in it."""
    R = T[:3, :3]
    return np.block([[R, np.cross(T[:3, 3, None], R, axis=0)], [np.zeros((3, 3)), R]])
