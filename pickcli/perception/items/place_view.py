"""What a picture shows of one place: a smaller picture, each pixel of which stands for a block."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from pickcli.cell.place import Place
from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.geometry import Array, inverse, pose, transform_points
from pickcli.perception.items.rgbd_picture import RgbdPicture
from pickcli.perception.procedural_texture import ColourPicture
from pickcli.perception.rendered_scene import RenderedScene
from pickcli.perception.surface_view import FloatPicture, SurfaceView

PIXEL = 0.002  # m on the nearest side of the place that a pixel covers, at least as much as one of the sensor
_BEYOND = 0.02  # m around the room in which surfaces belong to the place
_AVERAGED = 3  # px of normals
_NEAREST = 0.05  # m before the camera
_STEPS = 1  # px to both sides, for normals
_BEFORE = 0.01  # m before a surface: a solid that hides it


@dataclass(frozen=True, eq=False)
class PlaceView:
    """A place in a picture.

    Attributes:
        camera: Intrinsics of the smaller picture.
        T_camera_place: (4, 4) pose of the place in the camera's frame.
        depth: (height, width) m, the median of each block, NaN where none of it was measured.
        share: (height, width) share of each block that was measured.
        colour: (height, width, 3) mean of each block, 0 to 255.
        known: What would be seen if there were no items, NaN where that is not of the place.
        facing: (height, width) cosine between ray and normal of what is known; 0 where nothing came back as
            the second eye sees something else.
    """

    camera: PinholeCamera
    T_camera_place: Array
    depth: FloatPicture
    share: FloatPicture
    colour: Array
    known: SurfaceView
    facing: FloatPicture

    @property
    def points(self) -> Array:
        """(height, width, 3) measured points, m in the place's frame; NaN where nothing was measured."""
        return self._points_at(self.depth)

    @property
    def surface_points(self) -> Array:
        """(height, width, 3) measured points, known ones where none are, m in the place's frame."""
        return self._points_at(np.where(np.isfinite(self.depth), self.depth, self.known.depth))

    @cached_property
    def rays(self) -> Array:
        """(height, width, 3) rays through the middles of all pixels in the place's frame, of depth 1."""
        # Row by row: one large product would wake up the threads of BLAS.
        return np.asarray(self.camera.rays @ self.T_camera_place[:3, :3])

    def _points_at(self, depth: FloatPicture) -> Array:
        return np.asarray(inverse(self.T_camera_place)[:3, 3] + self.rays * depth[..., None])

    @property
    def normals(self) -> Array:
        """(height, width, 3) unit normals of the measured surface in the place's frame, towards the camera.

        By differences to neighbours; NaN where there are none.
        """
        points = self.points
        across, down = np.full_like(points, np.nan), np.full_like(points, np.nan)
        across[:, _STEPS:-_STEPS] = points[:, 2 * _STEPS :] - points[:, : -2 * _STEPS]
        down[_STEPS:-_STEPS] = points[2 * _STEPS :] - points[: -2 * _STEPS]
        normals = np.cross(down, across)
        is_known = np.asarray(np.isfinite(normals).all(axis=-1))
        weight = uniform_filter(is_known.astype(np.float64), _AVERAGED)
        normals = uniform_filter(np.where(is_known[..., None], normals, 0.0), (_AVERAGED, _AVERAGED, 1))
        normals[weight < 0.3] = np.nan
        return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12))

    @property
    def thinned(self) -> PlaceView:
        """The view with every second pixel of a row and of a column only."""
        c, each = self.camera, slice(None, None, 2)
        height, width = self.depth[each, each].shape
        camera = PinholeCamera(c.fx / 2, c.fy / 2, c.cx / 2, c.cy / 2, width, height)
        known = self.known
        return PlaceView(
            camera, self.T_camera_place, self.depth[each, each], self.share[each, each],
            self.colour[each, each],
            SurfaceView(
                camera, known.T_world_camera, known.depth[each, each], known.index[each, each],
                known.normals[each, each],
            ),
            self.facing[each, each],
        )  # fmt: skip


def view_of_place(
    rgbd: RgbdPicture, place: Place, T_world_place: Array, known: RenderedScene
) -> PlaceView | None:
    """Take what a picture shows of a place.

    Args:
        rgbd: The picture.
        place: The place.
        T_world_place: (4, 4) its pose.
        known: All that is known to be there, without items in the place.

    Returns:
        The view; None if the place is not in the picture.
    """
    T_camera_place = inverse(rgbd.T_world_camera) @ T_world_place
    window = _window(rgbd.sensor.camera, place, T_camera_place)
    if window is None:
        return None
    (u0, v0, width, height), size = window
    full = rgbd.sensor.camera
    camera = PinholeCamera(
        full.fx / size, full.fy / size, (full.cx - u0 - (size - 1) / 2) / size,
        (full.cy - v0 - (size - 1) / 2) / size, width, height,
    )  # fmt: skip
    rows, columns = slice(v0, v0 + height * size), slice(u0, u0 + width * size)
    depth, share = _medians(_blocks(rgbd.depth[rows, columns], size))
    colour = _means(rgbd.colour[rows, columns], size)
    view = known.seen_by(camera, rgbd.T_world_camera)
    rays = camera.rays
    facing = -(view.normals * rays).sum(axis=-1) / np.linalg.norm(rays, axis=-1)
    facing[(share == 0.0) & _in_shadow(view, known, rgbd.depth_model.baseline)] = 0.0
    seen = _of_place(view, place, T_world_place)
    return PlaceView(camera, T_camera_place, depth, share, colour, seen, facing.astype(np.float32))


def _window(
    camera: PinholeCamera, place: Place, T_camera_place: Array
) -> tuple[tuple[int, int, int, int], int] | None:
    """First column and row, numbers of blocks, and the size of a block in px."""
    room = place.room
    corners = np.array(
        [(x, y, z) for x in room.x_range for y in room.y_range for z in (room.low[2], room.high[2])]
    )
    points = transform_points(T_camera_place, corners)
    if not (points[:, 2] > _NEAREST).all():
        return None
    pixels = camera.project(points)
    low = np.clip(np.floor(pixels.min(axis=0)), 0, [camera.width, camera.height]).astype(int)
    high = np.clip(np.ceil(pixels.max(axis=0)) + 1, 0, [camera.width, camera.height]).astype(int)
    size = max(1, int(PIXEL * camera.fx / float(points[:, 2].min())))
    width, height = ((high - low) // size).tolist()
    if width < 2 * _STEPS + 1 or height < 2 * _STEPS + 1:
        return None
    return (int(low[0]), int(low[1]), width, height), size


def _blocks(picture: Array | FloatPicture, size: int) -> Array:
    """(height, width, size^2, ...) pixels of each block."""
    height, width = picture.shape[0] // size, picture.shape[1] // size
    rest = picture.shape[2:]
    parts = picture.reshape(height, size, width, size, *rest).swapaxes(1, 2)
    return np.asarray(parts.reshape(height, width, size * size, *rest))


def _means(colour: ColourPicture, size: int) -> Array:
    """(height, width, 3) mean colour of each block."""
    height, width = colour.shape[0] // size, colour.shape[1] // size
    of_rows = colour.reshape(height, size, width * size * 3).sum(axis=1, dtype=np.uint32)
    sums = of_rows.reshape(height, width, size, 3).sum(axis=2, dtype=np.uint32)
    return np.asarray(sums / size**2)


def _medians(blocks: Array) -> tuple[FloatPicture, FloatPicture]:
    """Medians of what was measured, and the shares that were."""
    ordered = np.sort(blocks, axis=2)  # NaN last
    counts = np.isfinite(ordered).sum(axis=2)
    middle = np.maximum(counts - 1, 0) // 2
    medians = np.take_along_axis(ordered, middle[..., None], axis=2)[..., 0]
    return medians.astype(np.float32), (counts / blocks.shape[2]).astype(np.float32)


def _in_shadow(view: SurfaceView, known: RenderedScene, baseline: float) -> NDArray[np.bool_]:
    """(height, width) whether known solids hide what is known from the sensor's second eye."""
    camera = view.camera
    if not baseline or not np.isfinite(view.depth).any():
        return np.zeros(view.depth.shape, dtype=bool)
    largest = int(np.ceil(camera.fx * baseline / np.nanmin(view.depth)))  # disparity, px
    beside = replace(camera, cx=camera.cx + largest, width=camera.width + largest)
    other = known.seen_by(beside, view.T_world_camera @ pose((baseline, 0.0, 0.0)))
    rows, columns = np.indices(view.depth.shape)
    with np.errstate(invalid="ignore"):
        shifted = columns + largest - camera.fx * baseline / view.depth
        nearest = np.where(np.isfinite(shifted), np.round(shifted), 0.0).astype(int)
        return np.asarray(other.depth[rows, nearest] < view.depth - _BEFORE)


def _of_place(view: SurfaceView, place: Place, T_world_place: Array) -> SurfaceView:
    """The view with NaN where what is known is outside of the place."""
    T_place_camera = inverse(T_world_place) @ view.T_world_camera
    points = transform_points(T_place_camera, view.points)
    low, high = place.room.low - _BEYOND, place.room.high + _BEYOND
    with np.errstate(invalid="ignore"):
        is_inside = ((points >= low) & (points <= high)).all(axis=-1)
        is_inside &= _through_mouth(view.camera, inverse(T_place_camera), place)
    return SurfaceView(
        view.camera, view.T_world_camera, np.where(is_inside, view.depth, np.float32(np.nan)), view.index,
        view.normals,
    )  # fmt: skip


def _through_mouth(camera: PinholeCamera, T_camera_place: Array, place: Place) -> NDArray[np.bool_]:
    """(height, width) whether rays pass the mouth of a place: beside it they show its neighbours."""
    access = place.access
    T_mouth_camera = inverse(T_camera_place @ access.T_place_mouth)
    eye, rays = T_mouth_camera[:3, 3], camera.rays @ T_mouth_camera[:3, :3].T
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = eye + (-eye[0] / rays[..., :1]) * rays
        return np.asarray(
            (rays[..., 0] > 0.0)
            & (np.abs(crossing[..., 1]) < access.width / 2)
            & (np.abs(crossing[..., 2]) < access.height / 2)
        )
