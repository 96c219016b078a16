"""A look of the truck's camera at the pallet that is expected, and what it says in the area's frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.driving.driving_area import StatedPallet
from pickcli.driving.steering_path import posed, seen_from, wrapped
from pickcli.driving.truck_camera import TruckCamera
from pickcli.errors import InputError
from pickcli.geometry import Array
from pickcli.perception.depth_picture import DepthPicture
from pickcli.perception.pallets.front_search import PalletZone
from pickcli.perception.pallets.pallet_pose import PalletEstimate, detect_pallet


def look_for_pallet(
    picture: DepthPicture, camera: TruckCamera, truck: Array, pallet: StatedPallet
) -> PalletEstimate:
    """Find a pallet in a picture.

    Args:
        picture: The picture; its world is the frame of the truck.
        camera: The camera that took it.
        truck: (3,) m, m, rad: where the truck is believed to have been.
        pallet: The pallet that is expected.

    Returns:
        The estimate, in the frame of the truck.

    Raises:
        InputError: The camera measures no depth, or there is no pallet, with the reason.
    """
    if camera.model.depth is None:
        raise InputError(f"sensor {camera.model.name}: measures no depth, by which pallets are found")
    expected = seen_from(truck, pallet.pose)
    zone = PalletZone(np.array([*expected[:2], *wrapped(expected[2:])]), pallet.tolerance)
    return detect_pallet(picture, camera.model.depth, pallet.shape, zone, camera.error)


def seen_pallet(estimate: PalletEstimate, truck: Array, pallet: StatedPallet) -> StatedPallet:
    """Put an expected pallet where it is seen.

    Args:
        estimate: What is seen, in the frame of the truck.
        truck: (3,) m, m, rad: where the truck is believed to have been.
        pallet: The pallet that was expected.

    Returns:
        The pallet there, in the frame of the area.
    """
    return replace(pallet, pose=posed(truck, estimate.pose))
