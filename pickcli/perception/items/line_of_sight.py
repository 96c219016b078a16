"""How far the rays of a picture go through space of a place in which nothing unexplained is.

A ray that met what an answer or the known place explains was clear up to there. One that met something else
was clear up to that, and one on which nothing was measured where something should have been was never clear.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label, minimum_filter

from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.geometry import Array, inverse, transform_points
from pickcli.perception.items.place_view import PIXEL
from pickcli.perception.surface_view import FloatPicture

LEAST_PIXELS = 8  # side by side: fewer that nothing explains are taken for errors of the sensor
# side by side, 11 by 11 mm of a surface: what shows less is too small for an item, and errors of poses and of
# colours at the edges of what is recognised are mostly smaller
LEAST_SURFACE = 32
_HALF_DIAGONAL = np.sqrt(3.0) / 2
_NEIGHBOURS = np.ones((3, 3))


@dataclass(frozen=True, eq=False)
class LineOfSight:
    """How far each ray of a picture is clear.

    Attributes:
        camera: Intrinsics of the picture.
        T_camera_place: (4, 4) pose of the place in the camera's frame.
        explained: (height, width) m of depth of what was met, measured or else as explained; 0 where nothing
            of the place is looked for.
        blocked: (height, width) m of depth from which on something that nothing explains blocks the ray;
            infinite where there is none.
    """

    camera: PinholeCamera
    T_camera_place: Array
    explained: FloatPicture
    blocked: FloatPicture

    def cubes(self, points: Array, width: float) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Tell what is known of cubes.

        Args:
            points: (N, 3) m, their middles in the place's frame.
            width: m, of the cubes.

        Returns:
            (N,) which are clear: the middle was seen through, and nothing unexplained is in or before any of
            their rays; and (N,) in or right behind which something was measured that nothing explains.
        """
        z, explained, blocked = self._along_rays(points, width)
        is_clear = (z < explained) & (z + width * _HALF_DIAGONAL < blocked)
        return np.asarray(is_clear), np.asarray(np.abs(z - blocked) < 2.0 * width)

    @property
    def eye(self) -> Array:
        """(3,) m, the camera's centre in the place's frame."""
        return np.asarray(inverse(self.T_camera_place)[:3, 3])

    @property
    def unexplained_points(self) -> Array:
        """(N, 3) m in the place's frame: measured surfaces that nothing explains, but not single pixels.

        Where nothing was measured, though something should have been, a ray does not tell where it is.
        """
        labels, _ = label(np.isfinite(self.blocked), _NEIGHBOURS)
        counts = np.bincount(labels.ravel())
        is_surface = (labels > 0) & (counts[labels] >= LEAST_SURFACE) & (self.blocked > 0.0)
        points = self.camera.rays[is_surface] * self.blocked[is_surface, None]
        return transform_points(inverse(self.T_camera_place), points)

    def _along_rays(self, points: Array, width: float) -> tuple[Array, Array, Array]:
        """Depths (N,) of points, of what rays to them met, and from where on these are blocked over a width.

        Out of the picture rays met something at once.
        """
        at = transform_points(self.T_camera_place, points)
        columns, rows = np.rint(self.camera.project(at)).astype(int).T
        height, n_columns = self.explained.shape
        is_inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < n_columns) & (at[:, 2] > 0.0)
        wide = minimum_filter(self.blocked, 2 * int(np.ceil(width / PIXEL / 2)) + 1)
        explained, blocked = np.zeros(len(points)), np.full(len(points), np.inf)
        own = rows[is_inside], columns[is_inside]
        explained[is_inside], blocked[is_inside] = self.explained[own], wide[own]
        return at[:, 2], explained, blocked


def unexplained_depth(
    depth: FloatPicture, is_unexplained: NDArray[np.bool_], is_odd: NDArray[np.bool_], thickness: float
) -> FloatPicture:
    """Compute from where on rays are blocked.

    Args:
        depth: (height, width) m measured, NaN where nothing was.
        is_unexplained: (height, width) where it is of nothing that is explained.
        is_odd: (height, width) where colours, or missing depth, are not what they should be.
        thickness: m of what may be there without being measured before what is explained.

    Returns:
        (height, width) m: the measured depth, 0 if there is none, infinite where nothing blocks.
    """
    labels, _ = label(is_unexplained | is_odd, _NEIGHBOURS)
    counts = np.bincount(labels.ravel())
    is_blocked = (labels > 0) & (counts[labels] >= LEAST_PIXELS)
    from_here = np.nan_to_num(depth - np.where(is_unexplained, 0.0, thickness))
    return np.where(is_blocked, from_here, np.inf).astype(np.float32)
