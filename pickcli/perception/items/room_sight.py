"""How much of a place's room a camera sees, were no items in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.place import Place, Room
from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.geometry import Array, inverse, transform_points
from pickcli.perception.rendered_scene import OwnerKind, RenderedScene
from pickcli.perception.surface_view import SurfaceView

LEAST_SEEN = 0.5  # share of a room, below which nothing is said of what is in it
_COARSER = 4  # px of a picture that one stands for here
_SAMPLES = (16, 12, 10)  # points of a room along its x, y and z
_NEAREST = 0.05  # m before the camera
_SLACK = 0.01  # m by which a surface may be before a point that is on it


@dataclass(frozen=True)
class RoomSight:
    """What becomes of rays from a camera to points all over a room.

    Attributes:
        seen: Share of the points that are in sight.
        hidden_by_robot: Share that links, or what the tool holds, hide.
        hidden: Share that carriers and obstacles hide.
    """

    seen: float
    hidden_by_robot: float
    hidden: float

    @property
    def is_enough(self) -> bool:
        """Whether enough is seen for answers."""
        return self.seen >= LEAST_SEEN

    @property
    def fault(self) -> str:
        """Why not enough is seen; "" if it is."""
        if self.is_enough:
            return ""
        beside = max(1.0 - self.seen - self.hidden_by_robot - self.hidden, 0.0)
        causes = (
            (self.hidden_by_robot, "hidden by the robot"),
            (self.hidden, "hidden by walls or obstacles"),
            (beside, "outside of the picture"),
        )
        told = ", ".join(f"{share:.0%} is {why}" for share, why in causes if share >= 0.005)
        return f"{self.seen:.0%} of its room is seen, at least {LEAST_SEEN:.0%} must be ({told})"


def coarse_view(camera: PinholeCamera, T_world_camera: Array, known: RenderedScene) -> SurfaceView:
    """Render what is known, with fewer pixels.

    Args:
        camera: Intrinsics of the camera.
        T_world_camera: (4, 4) its pose.
        known: All that is known to be there, without items in places.

    Returns:
        The view, by a camera whose pixels stand for several.
    """
    n = _COARSER
    width, height = max(camera.width // n, 1), max(camera.height // n, 1)
    middle = (n - 1) / 2  # of the first pixels that one stands for
    coarse = PinholeCamera(
        camera.fx / n, camera.fy / n, (camera.cx - middle) / n, (camera.cy - middle) / n, width, height
    )
    return known.seen_by(coarse, T_world_camera)


def room_sight(view: SurfaceView, known: RenderedScene, place: Place, T_world_place: Array) -> RoomSight:
    """Compute how much of a place's room a camera sees.

    Args:
        view: What it sees of ``known``, by ``coarse_view``.
        known: All that is known to be there, without items in places.
        place: The place.
        T_world_place: (4, 4) its pose.

    Returns:
        The shares.
    """
    T_camera_place = inverse(view.T_world_camera) @ T_world_place
    points = transform_points(T_camera_place, _points_in(place.room))
    points = points[points[:, 2] > _NEAREST]
    columns, rows = np.round(view.camera.project(points)).T
    inside = (columns >= 0) & (columns < view.camera.width) & (rows >= 0) & (rows < view.camera.height)
    at = rows[inside].astype(int), columns[inside].astype(int)
    with np.errstate(invalid="ignore"):
        is_hidden = view.depth[at] < points[inside, 2] - _SLACK
    is_own = np.array([solid.kind is not OwnerKind.CARRIER for solid in known.solids], dtype=bool)
    by_robot = is_own[view.index[at][is_hidden]].sum()
    n = int(np.prod(_SAMPLES))
    return RoomSight(
        float((~is_hidden).sum() / n), float(by_robot / n), float((is_hidden.sum() - by_robot) / n)
    )


def _points_in(room: Room) -> Array:
    """(N, 3) points, the middles of equal parts of a room, in the place's frame."""
    shares = [(np.arange(n) + 0.5) / n for n in _SAMPLES]
    x, y, up = (axis.ravel() for axis in np.meshgrid(*shares, indexing="ij"))
    x = room.x_range[0] + x * room.depth
    y = room.y_range[0] + y * (room.y_range[1] - room.y_range[0])
    floor, ceiling = room.floor_at(x), room.ceiling_at(x)
    return np.stack([x, y, floor + up * (ceiling - floor)], axis=-1)
