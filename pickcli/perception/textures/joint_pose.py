"""One pose of an item by its print in several pictures: bundle adjustment with the cameras known.

In one picture a print tells where it is across the rays to a few tenths of a millimetre, and along them
hardly at all. Pictures from several places cross their rays, so together they tell all of it, without depth:
of what is clear or shiny, too. The pose is that which brings the matched points of all pictures nearest to
where they were seen (least squares by Gauss-Newton steps, weighted after Geman and McClure; Triggs et al.
2000, Bundle Adjustment - A Modern Synthesis). What the pictures leave open is its covariance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.geometry import Array, inverse, pose, rotation_from_vector, transform_points

_SCALE = 0.0012  # of the depth, by which a match may be off the ray of its point before it counts little
_ITERATIONS = 12
# Covariance of what all matches of one picture are off alike, for where its camera is and how the print looks
# from there; and of what those of all pictures are, for damage and light. m and rad.
_OF_LOOK = np.diag(np.repeat([2e-4, np.radians(0.2)], 3) ** 2)
_OF_ALL = np.diag(np.repeat([1e-4, np.radians(0.17)], 3) ** 2)
_LEAST = 1e-9  # of the trace of the information: what no picture tells


@dataclass(frozen=True, eq=False)
class PrintSighting:
    """The print of an item in one picture.

    Attributes:
        camera: Intrinsics of the picture.
        T_camera_item: (4, 4) the pose by this picture alone.
        points: (N, 3) m, matched points of the item, in its frame.
        pixels: (N, 2) where they were seen.
    """

    camera: PinholeCamera
    T_camera_item: Array
    points: Array
    pixels: Array


@dataclass(frozen=True, eq=False)
class JointPose:
    """A pose by several pictures.

    Attributes:
        T_world_item: (4, 4).
        covariance: (6, 6) of small motions in the item's frame: a shift in m, then a turn in rad.
        off: Root mean square of how far matches are off their rays, of the depth.
        n_matches: Number of matches, each as much as it counts.
        counted: That as a share of all.
    """

    T_world_item: Array
    covariance: Array
    off: float
    n_matches: float
    counted: float


def joint_pose(seen: Sequence[tuple[Array, PrintSighting]]) -> JointPose:
    """Solve for the pose of an item by all pictures of its print.

    Args:
        seen: Pose (4, 4) of the camera in the world, and what was seen, of each picture; at least one.

    Returns:
        The pose, from that by the first picture on.
    """
    T = seen[0][0] @ seen[0][1].T_camera_item
    for _ in range(_ITERATIONS):
        linearised = [_linearised(each, inverse(T_camera) @ T) for T_camera, each in seen]
        gradient = np.sum([_weighted(J, off) @ off.ravel() for J, off in linearised], axis=0)
        step = -_inverse(np.sum(_informations(linearised), axis=0)) @ gradient
        T = T @ pose(step[:3], R=rotation_from_vector(step[3:]))
    linearised = [_linearised(each, inverse(T_camera) @ T) for T_camera, each in seen]
    off = np.concatenate([each for _, each in linearised])
    weights = _weights(off)
    n = float(weights.sum())
    variance = float(weights @ (off**2).sum(axis=1)) / max(2.0 * n - 6.0, 1.0)
    by_look = _informations(linearised)
    left_open = _inverse(np.sum(by_look, axis=0))
    alike = np.sum([own @ _OF_LOOK @ own for own in by_look], axis=0)
    covariance = variance * left_open + left_open @ alike @ left_open + _OF_ALL
    return JointPose(T, covariance, float(np.sqrt(variance)), n, n / len(weights))


def _weights(off: Array) -> Array:
    """(N,) how much matches count that are off (N, 2) their rays."""
    return np.asarray((1.0 + (off**2).sum(axis=1) / _SCALE**2) ** -2.0)


def _weighted(J: Array, off: Array) -> Array:
    """(6, 2 N) the rows of a picture, weighted."""
    return np.asarray((J * _weights(off)[:, None, None]).reshape(-1, 6).T)


def _informations(linearised: Sequence[tuple[Array, Array]]) -> list[Array]:
    """(6, 6) what each picture tells, over the variance of matches."""
    return [np.asarray(_weighted(J, off) @ J.reshape(-1, 6)) for J, off in linearised]


def _inverse(information: Array) -> Array:
    """(6, 6) its inverse, large in directions of which no picture tells."""
    return np.asarray(np.linalg.inv(information + _LEAST * np.trace(information) * np.eye(6)))


def _linearised(seen: PrintSighting, T_camera_item: Array) -> tuple[Array, Array]:
    """(N, 2, 6) how matches move with small motions of the item, and (N, 2) how far they are off."""
    at, camera = transform_points(T_camera_item, seen.points), seen.camera
    focal, middle = np.array([camera.fx, camera.fy]), np.array([camera.cx, camera.cy])
    slopes = at[:, :2] / at[:, 2:]
    of_camera = np.zeros((len(at), 2, 3))  # slopes by motions of the point in the camera's frame
    of_camera[:, 0, 0] = of_camera[:, 1, 1] = 1.0 / at[:, 2]
    of_camera[:, :, 2] = -slopes / at[:, 2:]
    moved = np.zeros((len(at), 3, 6))  # of the point in the item's frame by motions of the item
    moved[:, :, :3] = np.eye(3)
    moved[:, :, 3:] = np.cross(np.eye(3), seen.points[:, None, :]).swapaxes(1, 2)
    J = of_camera @ T_camera_item[:3, :3] @ moved
    return J, slopes - (seen.pixels - middle) / focal
