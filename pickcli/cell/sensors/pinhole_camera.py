"""Pinhole cameras in OpenCV's convention: x to the right, y down, z along the optical axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array


@dataclass(frozen=True)
class PinholeCamera:
    """Intrinsics of a camera without distortion.

    The middle of pixel (u, v), in column u and row v, is at u, v exactly, as in OpenCV.

    Attributes:
        fx: Focal length along a row, px.
        fy: Focal length along a column, px.
        cx: Column of the principal point, px.
        cy: Row of the principal point, px.
        width: Number of columns.
        height: Number of rows.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int

    @property
    def intrinsics(self) -> Array:
        """(4,) fx, fy, cx, cy, as the kernel takes them."""
        return np.array([self.fx, self.fy, self.cx, self.cy])

    @property
    def size(self) -> NDArray[np.int32]:
        """(2,) width and height as integers, as the kernel takes them."""
        return np.array([self.width, self.height], dtype=np.int32)

    @property
    def K(self) -> Array:
        """(3, 3) camera matrix, as OpenCV takes it."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    def project(self, points: Array) -> Array:
        """Project points to the picture.

        Args:
            points: (..., 3) m in the camera's frame, before the camera.

        Returns:
            (..., 2) column and row, px; outside of the picture where the camera does not see them.
        """
        return np.asarray(points[..., :2] / points[..., 2:] * [self.fx, self.fy] + [self.cx, self.cy])

    @property
    def rays(self) -> Array:
        """(height, width, 3) rays through the middles of all pixels in the camera's frame, at depth 1."""
        u, v = np.meshgrid(np.arange(self.width), np.arange(self.height))
        return np.stack([(u - self.cx) / self.fx, (v - self.cy) / self.fy, np.ones(u.shape)], axis=-1)
