"""Recordings of pictures: read back as they were taken, and refused with one clear line otherwise."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.sensors.mounted_camera import MountError
from pickcli.errors import InputError
from pickcli.files.png_file import write_png
from pickcli.geometry import from_quaternion, pose
from pickcli.perception.depth_picture import DEPTH_STEP, DepthPicture
from pickcli.perception.items.perceived_file import Perceived
from pickcli.perception.recorded_picture import read_recording, recording_values, write_recording

T_WORLD_CAMERA = pose((-0.3, 0.1, 1.4), R=from_quaternion((-0.5, 0.5, -0.5, 0.5)))


@pytest.fixture
def recorded(cell: Cell, tmp_path: Path) -> Path:
    """A recording of random colours, and of depths of 0.6 to 0.8 m with a hole."""
    camera, rng = cell.cameras["hand"], np.random.default_rng(3)
    shape = camera.model.camera.height, camera.model.camera.width
    depth = rng.uniform(0.6, 0.8, shape).astype(np.float32)
    depth[10:20, 10:30] = np.nan
    write_png(rng.integers(0, 256, (*shape, 3), dtype=np.uint8), tmp_path / "colour.png")
    taken = DepthPicture(camera.model.camera, T_WORLD_CAMERA, depth)
    write_png(taken.in_steps, tmp_path / "depth.png")
    path, pictures = tmp_path / "seen.json", (tmp_path / "colour.png", tmp_path / "depth.png")
    write_recording(recording_values((cell, camera), "cam_C", T_WORLD_CAMERA, pictures, path), path)
    return path


def test_a_recording_is_read_as_it_was_taken(recorded: Path, cell: Cell) -> None:
    content = json.loads(recorded.read_text())
    assert (content["colour"], content["depth"]) == ("colour.png", "depth.png")
    recording = read_recording(recorded)
    camera = recording.mounted(cell)
    assert camera.model == cell.cameras["hand"].model and recording.at == "cam_C"
    np.testing.assert_allclose(recording.T_world_camera, T_WORLD_CAMERA, atol=1e-12)
    depth, rng = recording.depth_picture(camera.model).depth, np.random.default_rng(3)
    truth = rng.uniform(0.6, 0.8, depth.shape)
    assert np.isnan(depth[10:20, 10:30]).all() and np.isnan(depth).sum() == 200
    assert np.nanmax(np.abs(depth - truth)) < 0.51 * DEPTH_STEP
    np.testing.assert_array_equal(
        recording.colour_picture(), rng.integers(0, 256, (*depth.shape, 3), dtype=np.uint8)
    )


def test_intrinsics_of_the_pictures_count(recorded: Path, cell: Cell) -> None:
    """And the noise stays that of the model."""
    content = json.loads(recorded.read_text())
    content["K"][0][0] = 1400.0
    recorded.write_text(json.dumps(content))
    model = read_recording(recorded).mounted(cell).model
    own = cell.cameras["hand"].model
    assert model.camera == replace(own.camera, fx=1400.0) and model.depth == own.depth


def test_depth_beyond_what_the_sensor_measures_is_none(recorded: Path, cell: Cell) -> None:
    model = cell.cameras["hand"].model
    assert model.depth is not None
    depth = np.full((model.camera.height, model.camera.width), 7000, dtype=np.uint16)
    depth[0], depth[1] = 3900, 65535
    write_png(depth, recorded.parent / "depth.png")
    read = read_recording(recorded).depth_picture(model).depth
    assert np.isnan(read[:2]).all() and np.isfinite(read[2:]).all()


def _k(row: int, column: int, value: float) -> Callable[[dict[str, Any]], None]:
    def change(content: dict[str, Any]) -> None:
        content["K"][row][column] = value

    return change


def _turned(content: dict[str, Any]) -> None:
    content["T_world_camera"][0][0] += 0.3


def _mirrored(content: dict[str, Any]) -> None:
    for row in content["T_world_camera"][:3]:
        row[0] *= -1.0


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (_k(0, 1, 2.0), "rectify the pictures"),
        (_k(1, 1, -5.0), "focal lengths must be above 0"),
        (_k(0, 2, 5000.0), "the principal point is outside of 1280 x 1024 px"),
        (_turned, "T_world_camera: is no rigid pose"),
        (_mirrored, "T_world_camera: is no rigid pose"),
        (lambda content: content.update(depth_step=0.0), "depth_step"),
        (lambda content: content.update(size=[640]), "size"),
        (lambda content: content.update(distortion=[0.1]), "distortion"),
    ],
)
def test_what_no_camera_has_is_refused(
    recorded: Path, change: Callable[[dict[str, Any]], None], told: str
) -> None:
    content = json.loads(recorded.read_text())
    change(content)
    recorded.write_text(json.dumps(content))
    with pytest.raises(InputError, match=told) as refused:
        read_recording(recorded)
    assert str(refused.value).count("\n") == 0 and str(refused.value).startswith(str(recorded))


def test_pictures_that_cannot_be_are_refused(recorded: Path, cell: Cell) -> None:
    recording, model = read_recording(recorded), cell.cameras["hand"].model
    shape = model.camera.height, model.camera.width
    cases: list[tuple[np.ndarray[Any, np.dtype[np.uint16]], float, str]] = [
        (np.full((480, 640), 7000, dtype=np.uint16), 1e-4, "640 x 480 px, but the camera has 1280 x 1024"),
        (np.zeros(shape, dtype=np.uint16), 1e-4, "nothing was measured in any pixel"),
        (np.full(shape, 700, dtype=np.uint16), 1e-4, "is 0.07 m in the median, but ensenso measures"),
        (np.full(shape, 7000, dtype=np.uint16), 1e-3, "state the unit of its steps in depth_step"),
        (np.full(shape, 3000, dtype=np.uint16), 1e-4, "nothing is within 0.4 to 1.307 m"),
    ]
    for depth, step, told in cases:
        write_png(depth, recorded.parent / "depth.png")
        with pytest.raises(InputError, match=told) as refused:
            replace(recording, depth_step=step).depth_picture(model)
        assert str(refused.value).startswith(str(recording.depth))
    for value in (0, 255):
        write_png(np.full((*shape, 3), value, dtype=np.uint8), recording.colour)
        with pytest.raises(InputError, match=r"colour\.png: 100% of the pixels are black or white"):
            recording.colour_picture()
    write_png(np.full((480, 640, 3), 90, dtype=np.uint8), recording.colour)
    with pytest.raises(InputError, match=r"has 640 x 480 px, but seen\.json says 1280 x 1024"):
        recording.colour_picture()


def test_other_cells_cameras_and_models_are_refused(recorded: Path, cell: Cell) -> None:
    recording = read_recording(recorded)
    for change, told in (
        ({"cell": "other"}, "is of cell other, not of apc2016_delft"),
        ({"camera": "foot"}, "has no camera foot, it has hand"),
        ({"sensor": "carmine"}, "camera hand of cell apc2016_delft is ensenso, not carmine"),
    ):
        with pytest.raises(InputError, match=told):
            replace(recording, **change).mounted(cell)  # type: ignore[arg-type]


def test_a_mount_that_is_off_moves_what_is_seen_from_elsewhere_by_no_more_than_its_bounds() -> None:
    """A turn about another picture's camera, seen about the first one's, is the same turn and a shift."""
    other = pose((0.0, 0.25, 1.4))
    seen = Perceived("c", "hand", "ensenso", pose((0.0, 0.0, 1.4)), (), also_from=(other,))
    mount, rng = MountError(0.001, np.radians(0.2)), np.random.default_rng(1)
    about = seen.error_about_camera(mount)
    for point in rng.uniform(-1.0, 1.0, (200, 3)):
        moved = mount.position + mount.angle * float(np.linalg.norm(point - other[:3, 3]))
        first = seen.T_world_camera[:3, 3]
        assert moved <= about.position + about.angle * float(np.linalg.norm(point - first)) + 1e-12
