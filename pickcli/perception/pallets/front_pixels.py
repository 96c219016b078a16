"""Pixels of a depth picture around a part of the scene, as rays from the camera in a frame on the floor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.sensors.sensor_model import DepthModel
from pickcli.geometry import Array
from pickcli.perception.depth_picture import DepthPicture


@dataclass(frozen=True, eq=False)
class FrontPixels:
    """Pixels with what was measured in them, if anything was.

    Attributes:
        centre: (3,) m, the camera.
        rays: (N, 3) at depth 1.
        depth: (N,) m along the optical axis, infinite where nothing was measured.
        spread: (N,) m, standard deviation of the depth; 0 where nothing was measured.
        pixel: Size of a pixel at depth 1.
    """

    centre: Array
    rays: Array
    depth: Array
    spread: Array
    pixel: float

    @classmethod
    def of(cls, picture: DepthPicture, noise: DepthModel, corners: Array, most: int) -> FrontPixels | None:
        """Take the pixels of the rectangle around points, thinned out.

        Args:
            picture: The picture; its world is the frame on the floor.
            noise: How its depth is measured.
            corners: (P, 3) m, the points.
            most: Number of pixels that may be left.

        Returns:
            The pixels; None if the points are not all before the camera, or beside of the picture.
        """
        camera, T = picture.camera, picture.T_world_camera
        local = (corners - T[:3, 3]) @ T[:3, :3]
        if local[:, 2].min() <= noise.least / 2:
            return None
        at = camera.project(local)
        low = np.maximum(np.floor(at.min(axis=0)), 0).astype(int)
        high = np.minimum(np.ceil(at.max(axis=0)) + 1, [camera.width, camera.height]).astype(int)
        if (high <= low).any():
            return None
        n = max(1, int(np.ceil(np.sqrt(np.prod(high - low) / most))))
        columns, rows = np.arange(low[0], high[0], n), np.arange(low[1], high[1], n)
        u, v = (grid.ravel() for grid in np.meshgrid(columns, rows))
        depth = picture.depth[v, u].astype(np.float64)
        rays = np.column_stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones(len(u))])
        spread = np.nan_to_num(noise.spread(depth, camera.fx))
        depth = np.where(np.isfinite(depth), depth, np.inf)
        return cls(T[:3, 3], rays @ T[:3, :3].T, depth, spread, 1.0 / camera.fx)
