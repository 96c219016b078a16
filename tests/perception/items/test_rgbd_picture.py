"""Pictures that perception cannot use are told, one clear message each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file
from pickcli.errors import InputError
from pickcli.perception.items.rgbd_picture import RgbdPicture
from support.filled_bins import Filled

CHANGES: dict[str, Callable[[RgbdPicture], RgbdPicture]] = {
    "depth: 3 x 2 px, but the camera has 1280 x 1024": lambda rgbd: replace(
        rgbd, depth=np.ones((2, 3), np.float32)
    ),
    "colour: 3 x 2 x 3 px, but depth 1280 x 1024 x 3;": lambda rgbd: replace(
        rgbd, colour=np.zeros((2, 3, 3), np.uint8)
    ),
    "depth: nothing was measured in any pixel": lambda rgbd: replace(
        rgbd, depth=np.full_like(rgbd.depth, np.nan)
    ),
    "depth: must be above 0 and finite": lambda rgbd: replace(rgbd, depth=np.zeros_like(rgbd.depth)),
    "depth: must be above 0 and finite, in m": lambda rgbd: replace(
        rgbd, depth=np.where(rgbd.depth > 0.6, rgbd.depth, np.float32(np.inf))
    ),
    "T_world_camera: is no rigid pose": lambda rgbd: replace(
        rgbd, T_world_camera=np.diag([1.0, 1.0, -1.0, 1.0])
    ),
    "sensor ids_wrist: is a colour camera": lambda rgbd: replace(
        rgbd, sensor=read_sensor(sensor_file("ids_wrist"))
    ),
}


@pytest.mark.parametrize("told", CHANGES)
def test_bad_pictures_are_told(filled: Filled, told: str) -> None:
    with pytest.raises(InputError) as error:
        CHANGES[told](filled.rgbd)
    assert told in str(error.value)
