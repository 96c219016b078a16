"""A pair of near-infrared cameras with a flash: figures, what a point looks like, and where a match lies.

Both cameras look along the truck's x, one beside the other, so that rows of both pictures correspond. The
frame of the truck has its origin on the floor under the middle of the axle, z up.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.geometry import Array

R_TRUCK_CAMERA = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])  # camera: x right, y down


@dataclass(frozen=True)
class NirPair:
    """Figures of the pair. Those of data/watches say where each comes from.

    Attributes:
        width: px of a row.
        height: px of a column.
        field_of_view: rad, horizontally.
        baseline: m between both cameras.
        forward: m of the cameras before the axle.
        above: m of the cameras above the floor.
        nearest: m along the optical axis, from where on people are found.
        farthest: m, to where they are.
        period: s between two exposures with flash.
        gap: s between the exposure with flash and the one without.
        delay: s from the exposure to the answer.
        flash: counts of a surface of 1 cd/lx/m^2 at 1 m, on the axis.
        flash_offset: m between lens and lamps, which makes the angle of observation.
        ambient: counts of a white surface without flash, indoors.
        full: electrons at the largest count.
        read_noise: counts, standard deviation.
        largest: counts, where pictures saturate.
        disparity_error: px, standard deviation that trackers count on.
    """

    width: int
    height: int
    field_of_view: float
    baseline: float
    forward: float
    above: float
    nearest: float
    farthest: float
    period: float
    gap: float
    delay: float
    flash: float
    flash_offset: float
    ambient: float
    full: float
    read_noise: float
    largest: float
    disparity_error: float

    @cached_property
    def camera(self) -> PinholeCamera:
        """Intrinsics of either camera."""
        f = self.width / 2 / np.tan(self.field_of_view / 2)
        return PinholeCamera(f, f, (self.width - 1) / 2, (self.height - 1) / 2, self.width, self.height)

    def T_truck_camera(self, is_right: bool) -> Array:
        """Return where a camera is.

        Args:
            is_right: Whether it is the right one.

        Returns:
            (4, 4) in the frame of the truck.
        """
        T = np.eye(4)
        T[:3, :3] = R_TRUCK_CAMERA
        T[:3, 3] = self.forward, self.baseline * (-0.5 if is_right else 0.5), self.above
        return T

    def projected(self, points: Array, is_right: bool) -> Array:
        """Return where a camera sees points.

        Args:
            points: (..., 3) m in the frame of the truck, before the cameras.
            is_right: Whether the right camera is meant.

        Returns:
            (..., 2) column and row, px.
        """
        T = self.T_truck_camera(is_right)
        return self.camera.project((points - T[:3, 3]) @ T[:3, :3])

    def triangulated(self, left: Array, right: Array) -> Array:
        """Return where matches lie: the inverse of ``projected``.

        Args:
            left: (..., 2) column and row in the left picture, px.
            right: (..., 2) in the right picture, with a smaller column.

        Returns:
            (..., 3) m in the frame of the truck; of both rows the mean is taken.
        """
        camera = self.camera
        depth = camera.fx * self.baseline / (left[..., 0] - right[..., 0])
        row = (left[..., 1] + right[..., 1]) / 2
        y = self.baseline / 2 - (left[..., 0] - camera.cx) * depth / camera.fx
        return np.stack([self.forward + depth, y, self.above - (row - camera.cy) * depth / camera.fy], -1)

    def covariance(self, place: Array) -> Array:
        """Return how well a match is known, from the errors of both columns to the first order.

        Args:
            place: (2,) m or more: x, y in the frame of the truck.

        Returns:
            (2, 2) m^2 of x and y.
        """
        depth, f, b = float(place[0]) - self.forward, self.camera.fx, self.baseline
        lateral = float(place[1])
        # With d = f b / Z: x = Z, y = b / 2 - (u_left - cx) Z / f, and u_left, u_right of independent errors.
        by_left = np.array([-(depth**2) / (f * b), -depth / f + (b / 2 - lateral) * depth / (f * b)])
        by_right = np.array([depth**2 / (f * b), -(b / 2 - lateral) * depth / (f * b)])
        jacobian = np.column_stack([by_left, by_right])
        return np.asarray(jacobian @ jacobian.T * self.disparity_error**2 / 2)
