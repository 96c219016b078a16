"""Recordings: what a camera took as colour and depth in PNG files, with intrinsics and its pose.

See docs/formats/recording.md.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.sensors.mounted_camera import MountedCamera
from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.cell.sensors.sensor_model import SensorModel
from pickcli.errors import InputError
from pickcli.files.atomic_write import write_text
from pickcli.files.file_kind import RECORDING
from pickcli.files.png_file import read_colour
from pickcli.files.schema import validate
from pickcli.files.source import Source
from pickcli.files.yaml_reader import read_yaml
from pickcli.geometry import Array, inverse, is_pose, rotation_angle
from pickcli.perception.depth_picture import DEPTH_STEP, DepthPicture, read_depth
from pickcli.perception.procedural_texture import ColourPicture
from pickcli.perception.recorded_picture_schema import RecordingModel
from pickcli.perception.surface_view import FloatPicture

MOST_SHIFT, MOST_ANGLE = 0.05, float(np.radians(5.0))  # m and rad by which a calibration may move a camera
_RIGID = 1e-4  # of the entries of a rotation, which drivers print with few digits
# Of the range that a sensor states: a recording beyond it was written in another unit.
_FAR_OFF = 2.0
# Share of pixels at one end of all three colours, from which on no colour tells items apart.
_MOST_SATURATED = 0.9
_DARK, _BRIGHT = 3, 252


@dataclass(frozen=True, eq=False)
class RecordedPicture:
    """A picture that a camera of a cell took, as its file describes it.

    Attributes:
        path: The file.
        cell: Name of the cell.
        camera: Name of the camera in it.
        sensor: Name of its model, whose noise the depth has.
        at: Where the arm was: a configuration of the cell, or joint positions with commas.
        intrinsics: Those of the pictures, which may be others than those of the model.
        T_world_camera: (4, 4) pose of the camera as the robot stated it.
        colour: File of the colour picture.
        depth: File of the depth, registered to it.
        depth_step: m of one of its steps.
    """

    path: Path
    cell: str
    camera: str
    sensor: str
    at: str
    intrinsics: PinholeCamera
    T_world_camera: Array
    colour: Path
    depth: Path
    depth_step: float

    def mounted(self, cell: Cell) -> MountedCamera:
        """Find the camera that took it.

        Args:
            cell: The cell.

        Returns:
            The camera, with the intrinsics of the pictures.

        Raises:
            InputError: The picture is of another cell, or the cell has no such camera or another model of it.
        """
        if self.cell != cell.name:
            raise InputError(f"{self.path}: is of cell {self.cell}, not of {cell.name}; name its cell")
        if self.camera not in cell.cameras:
            has = f"has {', '.join(cell.cameras)}" if cell.cameras else "has none"
            raise InputError(f"{self.path}: cell {cell.name} has no camera {self.camera}, it {has}")
        own = cell.cameras[self.camera]
        if own.model.name != self.sensor:
            raise InputError(
                f"{self.path}: camera {self.camera} of cell {cell.name} is {own.model.name}, "
                f"not {self.sensor}; state its model under sensors of the cell"
            )
        return replace(own, model=replace(own.model, camera=self.intrinsics))

    def refuse_elsewhere(self, T_world_camera: Array) -> None:
        """Refuse a pose that is not where the arm had the camera.

        Args:
            T_world_camera: (4, 4) pose of the camera by the cell, in the configuration ``at``.

        Raises:
            InputError: The stated one is farther from it than a calibration corrects.
        """
        off = inverse(T_world_camera) @ self.T_world_camera
        shift, angle = float(np.linalg.norm(off[:3, 3])), rotation_angle(off[:3, :3])
        if shift > MOST_SHIFT or angle > MOST_ANGLE:
            raise InputError(
                f"{self.path}: T_world_camera is {1e3 * shift:.0f} mm and {np.degrees(angle):.0f} degrees "
                f"from where the camera is with the arm at {self.at}; state both of the same moment"
            )

    def depth_picture(self, model: SensorModel) -> DepthPicture:
        """Read its depth.

        Args:
            model: The model of the camera, with the intrinsics of the pictures.

        Returns:
            The picture; what is beyond the range of the sensor counts as not measured.

        Raises:
            InputError: The file cannot be read, has another size, nothing was measured, or the depth is far
                beyond what the sensor measures.
        """
        depth = read_depth(self.depth, self.depth_step)
        try:
            DepthPicture(model.camera, self.T_world_camera, depth).check()
            return DepthPicture(model.camera, self.T_world_camera, self._in_range(depth, model))
        except InputError as error:
            raise InputError(f"{self.depth}: {error}") from None

    def colour_picture(self) -> ColourPicture:
        """Read its colours.

        Returns:
            (height, width, 3) red, green, blue.

        Raises:
            InputError: The file cannot be read, has another size, or is white or black nearly everywhere.
        """
        picture, size = read_colour(self.colour), (self.intrinsics.height, self.intrinsics.width)
        if picture.shape[:2] != size:
            has, needs = (" x ".join(str(n) for n in shape[1::-1]) for shape in (picture.shape, size))
            raise InputError(
                f"{self.colour}: has {has} px, but {self.path.name} says {needs}; both must be registered"
            )
        is_saturated = (picture <= _DARK).all(axis=2) | (picture >= _BRIGHT).all(axis=2)
        if (share := is_saturated.mean()) > _MOST_SATURATED:
            raise InputError(
                f"{self.colour}: {share:.0%} of the pixels are black or white, which tells no colours; "
                "expose it otherwise"
            )
        return picture

    def _in_range(self, depth: FloatPicture, model: SensorModel) -> FloatPicture:
        """Depth without what the sensor cannot measure."""
        assert model.depth is not None
        least, greatest, usual = model.depth.least, model.depth.greatest, float(np.nanmedian(depth))
        if not least / _FAR_OFF <= usual <= greatest * _FAR_OFF:
            raise InputError(
                f"depth: is {usual:.3g} m in the median, but {model.name} measures from {least:g} to "
                f"{greatest:g} m; state the unit of its steps in depth_step"
            )
        is_in_range = (depth >= least - self.depth_step) & (depth <= greatest + self.depth_step)
        if not is_in_range.any():
            raise InputError(
                f"depth: nothing is within {least:g} to {greatest:g} m, which {model.name} measures"
            )
        return np.where(is_in_range, depth, np.float32(np.nan)).astype(np.float32)


def read_recording(path: Path) -> RecordedPicture:
    """Read the file of a recording; its pictures are read when they are asked for.

    Args:
        path: The file; its pictures are named relative to it.

    Returns:
        The recording.

    Raises:
        InputError: The file has mistakes: with every problem.
    """
    source = read_yaml(path, RECORDING, is_json=True)
    model = validate(source, RecordingModel)
    K, T = np.array(model.K), np.array(model.T_world_camera)
    _check_intrinsics(source, K, model.size)
    if not is_pose(T, _RIGID):
        source.add(("T_world_camera",), "is no rigid pose: its rotation must be orthonormal, right-handed")
    source.check()
    intrinsics = PinholeCamera(K[0, 0], K[1, 1], K[0, 2], K[1, 2], *model.size)
    return RecordedPicture(
        path, model.cell, model.camera, model.sensor, model.at, intrinsics, _orthonormal(T),
        path.parent / model.colour, path.parent / model.depth, model.depth_step,
    )  # fmt: skip


def _check_intrinsics(source: Source, K: Array, size: tuple[int, ...]) -> None:
    """Refuse what is not [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] of a picture of a size."""
    if K[0, 1] or K[1, 0] or K[2, 0] or K[2, 1] or K[2, 2] != 1.0:
        source.add(("K",), "expected [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]; rectify the pictures")
    elif min(K[0, 0], K[1, 1]) <= 0.0:
        source.add(("K",), "focal lengths must be above 0")
    elif not (0.0 < K[0, 2] < size[0] and 0.0 < K[1, 2] < size[1]):
        fault = f"the principal point is outside of {size[0]} x {size[1]} px; is K of these pictures?"
        source.add(("K",), fault)


def _orthonormal(T: Array) -> Array:
    """The pose (4, 4) with the nearest rotation: that of a file has few digits."""
    U, _, Vt = np.linalg.svd(T[:3, :3])
    out = T.copy()
    out[:3, :3] = U @ Vt
    return out


def recording_values(
    of: tuple[Cell, MountedCamera], at: str, T_world_camera: Array, pictures: tuple[Path, Path], beside: Path
) -> dict[str, Any]:
    """Describe pictures that a camera took, as a file of a recording does.

    Args:
        of: The cell and its camera.
        at: Where the arm was.
        T_world_camera: (4, 4) stated pose of the camera.
        pictures: Files of colour and of depth in steps of ``DEPTH_STEP``.
        beside: The file of the recording, relative to whose folder they are named.

    Returns:
        The content of the file.
    """
    cell, camera = of
    colour, depth = (_relative(path, beside.parent) for path in pictures)
    return {
        "format": "apc recording",
        "version": 1,
        "cell": cell.name,
        "camera": camera.name,
        "sensor": camera.model.name,
        "at": at,
        "size": [camera.model.camera.width, camera.model.camera.height],
        "K": camera.model.camera.K.tolist(),
        "T_world_camera": T_world_camera.tolist(),
        "colour": colour,
        "depth": depth,
        "depth_step": DEPTH_STEP,
    }


def _relative(path: Path, folder: Path) -> str:
    """A file as named from a folder, if it is in it or below."""
    full, base = path.resolve(), folder.resolve()
    return str(full.relative_to(base)) if full.is_relative_to(base) else str(full)


def write_recording(values: dict[str, Any], path: Path, replace: bool = True) -> None:
    """Write the file of a recording atomically.

    Args:
        values: Its content.
        path: The file.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written.
    """
    write_text(path, json.dumps(values, indent=1) + "\n", replace)
