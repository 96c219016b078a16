"""Depth as a sensor measures it, with noise."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.cell.sensors.sensor_model import DepthModel, SensorModel
from pickcli.errors import InputError
from pickcli.files.png_file import read_grey
from pickcli.geometry import Array, is_pose
from pickcli.kernel import DepthNoise
from pickcli.perception.rendered_scene import RenderedScene
from pickcli.perception.surface_view import FloatPicture
from pickcli.seeds import derived_seed

DEPTH_STEP = 1e-4  # m, of depth in 16 bits: up to 6.55 m
_NOT_OF_KERNEL = ("no_return",)  # given by solid


@dataclass(frozen=True, eq=False)
class DepthPicture:
    """Depth of all pixels.

    Attributes:
        camera: Intrinsics of the camera.
        T_world_camera: (4, 4) its pose.
        depth: (height, width) m along the optical axis, float32, NaN where nothing was measured.
    """

    camera: PinholeCamera
    T_world_camera: Array
    depth: FloatPicture

    def check(self) -> None:
        """Refuse a picture that no camera takes.

        Raises:
            InputError: It has another size than the camera, nothing was measured, depths are not above 0, or
                the camera has no pose.
        """
        size = (self.camera.height, self.camera.width)
        if self.depth.shape != size:
            has, needs = (" x ".join(str(n) for n in shape[::-1]) for shape in (self.depth.shape, size))
            raise InputError(f"depth: {has} px, but the camera has {needs}; take its own picture")
        if not np.isfinite(self.depth).any():
            raise InputError("depth: nothing was measured in any pixel; check range and unit (m)")
        if np.nanmin(self.depth) <= 0.0 or np.isinf(self.depth).any():
            raise InputError("depth: must be above 0 and finite, in m, and NaN where nothing was measured")
        if not is_pose(self.T_world_camera):
            raise InputError("T_world_camera: is no rigid pose (4, 4); its rotation must be orthonormal")

    @property
    def in_steps(self) -> NDArray[np.uint16]:
        """(height, width) depth in steps of ``DEPTH_STEP``, 0 where nothing was measured or it is too far."""
        steps = np.rint(np.nan_to_num(self.depth.astype(np.float64)) / DEPTH_STEP)
        return np.where(steps <= np.iinfo(np.uint16).max, steps, 0).astype(np.uint16)

    @property
    def points(self) -> Array:
        """(height, width, 3) measured points, m in the camera's frame; NaN where nothing was measured."""
        return np.asarray(self.camera.rays * self.depth[..., None])


def measure_depth(
    rendered: RenderedScene, sensor: SensorModel, T_world_camera: Array, seed: int
) -> DepthPicture:
    """Measure depth with the noise of a sensor.

    Args:
        rendered: The solids.
        sensor: The sensor.
        T_world_camera: (4, 4) its true pose.
        seed: Seed of the noise: same seed, same bytes.

    Returns:
        The picture.

    Raises:
        InputError: The sensor measures no depth.
    """
    if sensor.depth is None:
        raise InputError(f"sensor {sensor.name}: is a colour camera, which measures no depth; choose another")
    share = sensor.depth.no_return
    no_return = [share.get(each.item.material, 0.0) if each.item else 0.0 for each in rendered.solids]
    camera = sensor.camera
    depth = rendered.kernel.measured_depth(
        camera.intrinsics, camera.size, T_world_camera, kernel_noise(sensor.depth), np.array(no_return),
        derived_seed(seed, "depth", sensor.name),
    )  # fmt: skip
    return DepthPicture(camera, T_world_camera, depth)


def read_depth(path: Path, step: float = DEPTH_STEP) -> FloatPicture:
    """Read depth that was recorded.

    Args:
        path: A grey PNG of 16 bits, 0 where nothing was measured.
        step: m of one step.

    Returns:
        (height, width) m, NaN where nothing was measured.

    Raises:
        InputError: The file cannot be read, or is no such picture.
    """
    steps = read_grey(path)
    return np.where(steps > 0, steps * np.float32(step), np.float32(np.nan)).astype(np.float32)


def kernel_noise(model: DepthModel) -> DepthNoise:
    """Convert the coefficients of a sensor for the kernel.

    Args:
        model: The coefficients.

    Returns:
        The same in the kernel.
    """
    names = (field.name for field in fields(model) if field.name not in _NOT_OF_KERNEL)
    return DepthNoise(**{name: getattr(model, name) for name in names})
