"""Bounds of the error of the pod's estimated pose: within them are 99 of 100, or should be.

The factor of a `floor_pose_bound` is one for all sensors and views: that of the sensor that needs most, by
which 99.5 % of the poses of drawn pods had all their errors within
(``python -m bench.pod_pose --shifts 200 --seed 1 --calibrate``). It was fitted to pods that are solid to the
floor, before those of the cells stood on legs, and not again since; docs/perception.md has how often bounds
with it hold for pods on legs.
"""

from __future__ import annotations

import numpy as np

from pickcli.cell.pod_tolerance import Displacement
from pickcli.cell.sensors.mounted_camera import MountError
from pickcli.geometry import Array
from pickcli.perception.floor_pose_bound import ROUNDING, pose_bound
from pickcli.perception.pod_fit import PodFit

FACTOR = 2.5  # of standard deviations


def pod_bound(fit: PodFit, mount: MountError, factor: float = FACTOR) -> Displacement:
    """Bound the error of an estimated pose.

    Args:
        fit: The fit.
        mount: Bounds of the error of the camera's pose.
        factor: Of standard deviations.

    Returns:
        Bounds of the true pod's pose in the frame of the estimated one.
    """
    return pose_bound(fit, mount, factor)


def front_bound(fit: PodFit, mount: MountError, front: Array, factor: float = FACTOR) -> float:
    """Bound how far any point of the pod's front is off.

    That is less than x, y and yaw could make possible together: what is seen well is known well, wherever the
    origin of the pod's frame is.

    Args:
        fit: The fit.
        mount: Bounds of the error of the camera's pose.
        front: (P, 2) x and y of its ends, m in the frame of the pod: between them it is less.
        factor: Of standard deviations.

    Returns:
        m.
    """
    covariance = np.linalg.inv(fit.information)
    most = 0.0
    for x, y in front:
        moved = np.array([[1.0, 0.0, -y], [0.0, 1.0, x]])  # that point, by the pod
        by_camera = mount.position * np.linalg.norm(moved @ fit.by_camera[:, :3], 2)
        by_camera += mount.angle * np.linalg.norm(moved @ fit.by_camera[:, 3:], 2)
        open_left = factor * np.sqrt(np.linalg.norm(moved @ covariance @ moved.T, 2))
        rounding = ROUNDING[0] + ROUNDING[2] * np.hypot(x, y)
        most = max(most, float(by_camera + open_left + rounding))
    return most
