"""Pictures with depth and colour, as perception takes them."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.cell.sensors.sensor_model import DepthModel, SensorModel
from pickcli.errors import InputError
from pickcli.geometry import Array
from pickcli.perception.depth_picture import DepthPicture
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
        name = self.sensor.name
        if self.sensor.depth is None:
            raise InputError(f"sensor {name}: is a colour camera; items are found with depth, choose another")
        DepthPicture(self.sensor.camera, self.T_world_camera, self.depth).check()
        if self.colour.shape != (*self.depth.shape, 3):
            has, needs = _size(self.colour.shape), _size((*self.depth.shape, 3))
            raise InputError(f"colour: {has} px, but depth {needs}; both must be registered")

    @property
    def depth_model(self) -> DepthModel:
        """How its depth is measured."""
        assert self.sensor.depth is not None
        return self.sensor.depth


def _size(shape: tuple[int, ...]) -> str:
    return " x ".join(str(n) for n in (*shape[1::-1], *shape[2:]))
