"""Bounds of the error of an estimated pose on the floor, from how far what is seen leaves it open.

What the picture leaves open follows from how fast the cost of the fit grows (Laplace's approximation), times
a factor that is fitted to pictures of known poses. By how much an error of the camera's own pose moves the
fit is known to the first order, so that its bounds carry over.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from pickcli.cell.pod_tolerance import Displacement
from pickcli.cell.sensors.mounted_camera import MountError
from pickcli.geometry import Array

ROUNDING = np.array([1e-4, 1e-4, np.radians(0.01)])  # m, m and rad: errors below are alike


class FittedPose(Protocol):
    """A pose on the floor that was fitted to a picture."""

    @property
    def information(self) -> Array:
        """(3, 3) second derivatives of the cost of x, y and yaw in the body's own frame."""

    @property
    def by_camera(self) -> Array:
        """(3, 6) motion in that frame by the motion of the camera: 3 shifts in m, 3 turns in rad."""


def pose_bound(fit: FittedPose, mount: MountError, factor: float) -> Displacement:
    """Bound the error of an estimated pose.

    Args:
        fit: The fit.
        mount: Bounds of the error of the camera's pose.
        factor: Of standard deviations.

    Returns:
        Bounds of the true pose in the frame of the estimated one.
    """
    open_left = factor * np.sqrt(np.diag(np.linalg.inv(fit.information)))
    by_camera = mount.position * np.linalg.norm(fit.by_camera[:, :3], axis=1)
    by_camera += mount.angle * np.linalg.norm(fit.by_camera[:, 3:], axis=1)
    x, y, yaw = open_left + by_camera + ROUNDING
    return Displacement(float(x), float(y), float(yaw))
