"""The camera on the truck, which looks along its forks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.sensors.mounted_camera import MountError
from pickcli.cell.sensors.sensor_model import SensorModel
from pickcli.geometry import Array, pose

USUAL_ERROR = MountError(0.002, 0.002)


@dataclass(frozen=True, eq=False)
class TruckCamera:
    """A camera of depth on the truck.

    Attributes:
        model: Its model.
        position: (3,) m in the frame of the truck, on the floor in the middle of its axle, z up.
        pitch: rad by which it looks down; it looks along -x, as the forks point.
        error: Bounds of the error of that pose.
    """

    model: SensorModel
    position: tuple[float, float, float] = (0.85, 0.0, 0.5)
    pitch: float = 0.5
    error: MountError = USUAL_ERROR

    @property
    def T_truck_camera(self) -> Array:
        """(4, 4) its pose: x right, y down, z along the optical axis."""
        c, s = np.cos(self.pitch), np.sin(self.pitch)
        R = np.array([[0.0, s, -c], [1.0, 0.0, 0.0], [0.0, -c, -s]])
        return pose(self.position, R=R)


def floor_pose(at: Array) -> Array:
    """Return the pose of what stands on the floor.

    Args:
        at: (3,) m, m, rad.

    Returns:
        (4, 4).
    """
    return pose((at[0], at[1], 0.0), rpy=(0.0, 0.0, float(at[2])))
