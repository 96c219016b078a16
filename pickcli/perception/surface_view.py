"""What a camera sees without noise: depth, solids and normals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.geometry import Array

FloatPicture: TypeAlias = NDArray[np.float32]
IndexPicture: TypeAlias = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class SurfaceView:
    """Depth, solids and normals of all pixels, exact up to single precision.

    Attributes:
        camera: Intrinsics of the camera.
        T_world_camera: (4, 4) its pose.
        depth: (height, width) m along the optical axis, float32, NaN where nothing is seen (as in REP 118 of
            ROS).
        index: (height, width) indices of the solids that are seen, int32, -1 where none is.
        normals: (height, width, 3) outward normals of their surfaces in the camera's frame, float32, NaN
            where nothing is seen.
    """

    camera: PinholeCamera
    T_world_camera: Array
    depth: FloatPicture
    index: IndexPicture
    normals: FloatPicture

    @property
    def points(self) -> Array:
        """(height, width, 3) points that are seen, m in the camera's frame; NaN where nothing is seen."""
        return np.asarray(self.camera.rays * self.depth[..., None])

    @property
    def incidence(self) -> Array:
        """(height, width) angles between rays and normals, rad in [0, pi/2]; NaN where nothing is seen."""
        rays = self.camera.rays
        cosine = -(rays * self.normals).sum(axis=-1) / np.linalg.norm(rays, axis=-1)
        return np.asarray(np.arccos(np.clip(cosine, 0.0, 1.0)))
