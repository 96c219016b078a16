"""Cameras at their places in a cell."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.cell.sensors.sensor_model import SensorModel
from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class MountError:
    """Bounds of the error of a camera's stated pose: hand-eye error, if it is on a link.

    Attributes:
        position: m, norm of the translation error.
        angle: rad, rotation error.
    """

    position: float
    angle: float


@dataclass(frozen=True, eq=False)
class MountedCamera:
    """A camera in a cell.

    Attributes:
        name: Name in the cell.
        model: Model of the camera.
        link: Link that it is mounted on; None if it is fixed in the world.
        T_parent_camera: (4, 4) stated pose in the frame of that link, or in the world.
        error: Bounds of the error of that pose.
    """

    name: str
    model: SensorModel
    link: str | None
    T_parent_camera: Array
    error: MountError
