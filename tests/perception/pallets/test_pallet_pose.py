"""Pallets found in depth pictures, and what is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file
from pickcli.cell.sensors.mounted_camera import MountError
from pickcli.driving.area_view import take_picture
from pickcli.driving.driving_area import DrivingArea, FloorBox, StatedPallet
from pickcli.driving.steering_path import seen_from
from pickcli.driving.truck_camera import TruckCamera
from pickcli.errors import InputError
from pickcli.geometry import Array
from pickcli.perception.depth_picture import DepthPicture
from pickcli.perception.pallets.front_search import PalletZone
from pickcli.perception.pallets.pallet_pose import PalletEstimate, detect_pallet
from pickcli.perception.pallets.pallet_shape import EUR_FULL, EUR_HALF, PalletShape

CAMERA = TruckCamera(read_sensor(sensor_file("carmine")))
TRUCK = np.zeros(3)
TOLERANCE = np.array([0.25, 0.25, 0.25])
PLACE = np.array([-1.4, 0.1, 0.15])  # of a full pallet, whose front is 1.65 m before the camera


def picture(*pallets: StatedPallet, boxes: tuple[FloorBox, ...] = (), seed: int = 1) -> DepthPicture:
    area = DrivingArea((-6.0, -4.0), (4.0, 4.0), boxes, TRUCK, TRUCK)
    return take_picture(area, CAMERA, TRUCK, pallets, seed)


def pallet(at: Array = PLACE, shape: PalletShape = EUR_FULL, load: float = 0.0) -> StatedPallet:
    return StatedPallet(shape, at, load, TOLERANCE)


def found(seen: DepthPicture, shape: PalletShape = EUR_FULL, at: Array = PLACE) -> PalletEstimate:
    assert CAMERA.model.depth is not None
    off = np.array([0.1, -0.1, 0.1])
    return detect_pallet(seen, CAMERA.model.depth, shape, PalletZone(at + off, TOLERANCE))


def test_its_boards_fill_the_size_of_a_eur_pallet() -> None:
    low = np.min([body.T_parent_shape[:3, 3] - body.shape.extents / 2 for body in EUR_FULL.bodies], axis=0)
    high = np.max([body.T_parent_shape[:3, 3] + body.shape.extents / 2 for body in EUR_FULL.bodies], axis=0)
    np.testing.assert_allclose(high - low, [1.2, 0.8, 0.144])
    np.testing.assert_allclose(EUR_FULL.pockets[1] - EUR_FULL.pockets[0], 0.3725)
    np.testing.assert_allclose(np.diff(EUR_FULL.pockets), 0.2275)


@pytest.mark.parametrize("load", [0.0, 0.8])
@pytest.mark.parametrize(
    ("shape", "at"),
    [(EUR_FULL, PLACE), (EUR_HALF, PLACE), (EUR_FULL, np.array([-2.1, -0.3, -0.3])),
     (replace(EUR_FULL, block_height=0.114), PLACE)],
)  # fmt: skip
def test_a_pallet_is_found_within_its_bounds(shape: PalletShape, at: Array, load: float) -> None:
    estimate = found(picture(pallet(at, shape, load)), shape, at)
    off = np.abs(seen_from(estimate.pose, at))
    assert (off <= [estimate.error.x, estimate.error.y, estimate.error.yaw]).all()
    assert off[0] < 0.008 and off[1] < 0.008 and off[2] < np.radians(0.7)
    assert estimate.n_pixels > 500 and 0.0 < estimate.residual < 0.02


def test_the_same_picture_gives_the_same_pose_and_a_camera_that_may_be_off_wider_bounds() -> None:
    seen = picture(pallet())
    one, other = found(seen), found(seen)
    assert one.pose.tobytes() == other.pose.tobytes()
    assert CAMERA.model.depth is not None
    zone = PalletZone(PLACE, TOLERANCE)
    wide = detect_pallet(seen, CAMERA.model.depth, EUR_FULL, zone, MountError(0.002, 0.002))
    # A camera that is off by 2 mm moves what it sees by 2 mm, and one that is turned turns it.
    assert wide.error.y > one.error.y + 0.002 and wide.error.yaw > one.error.yaw + 0.0015


def test_a_box_before_a_part_of_it_does_not_hide_it() -> None:
    before = FloorBox("before", (-0.5, 0.35), (0.15, 0.15), 0.3, 0.2)
    whole, partly = found(picture(pallet())), found(picture(pallet(), boxes=(before,)))
    assert partly.visible < whole.visible - 0.05
    assert np.hypot(*seen_from(partly.pose, PLACE)[:2]) < 0.01


@pytest.mark.parametrize("height", [0.144, 0.6])
def test_a_box_of_its_size_is_no_pallet(height: float) -> None:
    crate = FloorBox("crate", (PLACE[0], PLACE[1]), (1.2, 0.8), PLACE[2], height)
    with pytest.raises(InputError, match="no pallet here"):
        found(picture(boxes=(crate,)))


def test_bare_floor_and_other_widths_are_no_pallet() -> None:
    with pytest.raises(InputError, match="no pallet here: nowhere in the zone"):
        found(picture())
    narrow = replace(EUR_FULL, width=0.6, deck=(0.1, 0.1, 0.1))
    with pytest.raises(InputError, match="no pallet here"):
        found(picture(pallet(PLACE, narrow)))


def test_a_pallet_beyond_the_zone_is_not_the_one_that_is_expected() -> None:
    with pytest.raises(InputError, match="no pallet here"):
        found(picture(pallet(PLACE + np.array([0.0, 0.9, 0.0]))))


def test_a_picture_in_another_unit_is_refused() -> None:
    seen = picture(pallet())
    with pytest.raises(InputError, match="another unit"):
        found(DepthPicture(seen.camera, seen.T_world_camera, 1000 * seen.depth))
