"""Pictures with depth and colour, as perception takes them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.sensors.sensor_model import DepthModel, SensorModel
from pickcli.errors import InputError
from pickcli.geometry import Array, is_pose
from pickcli.perception.procedural_texture import ColourPicture
from pickcli.perception.surface_view import FloatPicture


@dataclass(frozen=True, eq=False)
class RgbdPicture:
    """One look of a camera: depth, and colour in the same pixels.

    Attributes:
        sensor: The sensor, with intrinsics and the stated noise of its depth.
        T_world_camera: (4, 4) stated pose of the camera.
        depth: (height, width) m along the optical axis, float32, NaN where nothing was measured.
        colour: (height, width, 3) red, green, blue, 0 to 255.

    Raises:
        InputError: The pictures do not fit the sensor, or hold nothing that was measured.
    """

    sensor: SensorModel
    T_world_camera: Array
    depth: FloatPicture
    colour: ColourPicture

    def __post_init__(self) -> None:
        camera, name = self.sensor.camera, self.sensor.name
        size = (camera.height, camera.width)
        if self.sensor.depth is None:
            raise InputError(f"sensor {name}: is a colour camera; items are found with depth, choose another")
        if self.depth.shape != size:
            raise InputError(f"depth: {_size(self.depth.shape)} px, sensor {name} has {_size(size)} px")
        if self.colour.shape != (*size, 3):
            raise InputError(
                f"colour: {_size(self.colour.shape)} px, sensor {name} has {_size((*size, 3))}; depth and "
                "colour must be registered"
            )
        if not np.isfinite(self.depth).any():
            raise InputError("depth: nothing was measured in any pixel; check range and unit (m)")
        if np.nanmin(self.depth) <= 0.0 or np.isinf(self.depth).any():
            raise InputError("depth: must be above 0 and finite, in m, and NaN where nothing was measured")
        if not is_pose(self.T_world_camera):
            raise InputError("T_world_camera: is no rigid pose (4, 4); its rotation must be orthonormal")

    @property
    def depth_model(self) -> DepthModel:
        """How its depth is measured."""
        assert self.sensor.depth is not None
        return self.sensor.depth


def _size(shape: tuple[int, ...]) -> str:
    return " x ".join(str(n) for n in (*shape[1::-1], *shape[2:]))
