"""From where the cameras of a cell look into a place: straight on, aslant from both sides, and further ones.

Looks from different places err differently: what hides an item, gives no depth or leaves a side in doubt in
one of them does not in another. And a camera that is off its stated pose sees things aside the other way
when it is turned, which tells the error of its mount from where things are. Where that is not enough, there
are views from farther aside, from above and from below.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.cell import Cell, NamedConfiguration
from pickcli.cell.place import Place
from pickcli.cell.sensors.mounted_camera import MountedCamera
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import InputError
from pickcli.geometry import Array, inverse, pose, rotation_axis_angle
from pickcli.kinematics.arm import Arm
from pickcli.perception.camera_pose import camera_pose
from pickcli.perception.items.room_sight import LEAST_SEEN, coarse_view, room_sight
from pickcli.perception.rendered_scene import RenderedScene
from pickcli.scene.scene import Scene, empty_scene

CAMERA_KIND = "camera"  # of named configurations in which cameras look
ASLANT = float(np.radians(20.0))  # turn of a camera about the vertical through the middle of a mouth
_SIDES = (("left", ASLANT), ("right", -ASLANT))
_FAR = float(np.radians(32.0))  # aside: farther, walls hide more than half of most bins
_TILT = float(np.radians(15.0))  # about the camera's horizontal axis: over lips, and over what lies in front
# share of a room, by which the sight of it may be less than from where a camera is stated to be
_RESERVE = 0.02
_FURTHER = (
    ("far_left", _FAR, 0.0), ("far_right", -_FAR, 0.0), ("below", 0.0, _TILT), ("above", 0.0, -_TILT),
    ("left_below", ASLANT, _TILT), ("right_below", -ASLANT, _TILT),
    ("left_above", ASLANT, -_TILT), ("right_above", -ASLANT, -_TILT),
    ("far_left_below", _FAR, _TILT), ("far_right_below", -_FAR, _TILT),
    ("far_left_above", _FAR, -_TILT), ("far_right_above", -_FAR, -_TILT),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Viewpoint:
    """From where a place is looked into.

    Attributes:
        camera: The camera.
        at: The configuration of the arm.
        T_world_camera: (4, 4) stated pose of the camera there.
    """

    camera: MountedCamera
    at: NamedConfiguration
    T_world_camera: Array

    @property
    def name(self) -> tuple[str, str]:
        """Names of the camera and of the configuration."""
        return self.camera.name, self.at.name


def viewpoint_of(place: Place, cell: Cell) -> Viewpoint:
    """Choose from where to look into a place: from where a depth camera sees most of its room.

    Args:
        place: The place.
        cell: Its cell.

    Returns:
        The viewpoint.

    Raises:
        InputError: No depth camera sees enough of it.
    """
    best, most = None, LEAST_SEEN
    for viewpoint in _stated_viewpoints(cell):
        seen = _seen_from(viewpoint, place, empty_scene(cell))
        if seen > most:
            most, best = seen, viewpoint
    if best is None:
        raise InputError(
            f"{place.name}: no depth camera of {cell.name} sees half of its room from a configuration of "
            f"kind {CAMERA_KIND}; state one (docs/formats/cell.md)"
        )
    return best


def sees_all_bins(cell: Cell) -> bool:
    """Tell whether depth cameras of a cell see enough of all places that are not open above.

    Args:
        cell: The cell.

    Returns:
        Whether they do; of a cell without such places that they do not.
    """
    bins = [place for place in cell.places.values() if not place.access.is_from_above]
    viewpoints = list(_stated_viewpoints(cell))
    return bool(bins) and all(
        any(_seen_from(viewpoint, place, empty_scene(cell)) > LEAST_SEEN for viewpoint in viewpoints)
        for place in bins
    )


def refuse_unseen_bins(cell: Cell) -> None:
    """Refuse a cell in which depth cameras do not see enough of a place that is not open above.

    Args:
        cell: The cell.

    Raises:
        InputError: They do not.
    """
    for place in cell.places.values():
        if not place.access.is_from_above:
            viewpoint_of(place, cell)


def viewpoints_of(place: Place, cell: Cell) -> tuple[Viewpoint, ...]:
    """Choose several places from which to look into a place.

    Args:
        place: The place.
        cell: Its cell.

    Returns:
        The viewpoint of ``viewpoint_of``; and, if the arm moves the camera, those turned by ``ASLANT`` to
        both sides about the vertical through the middle of the mouth, from which it sees enough, and where
        the arm keeps its clearance wherever the pod may stand.

    Raises:
        InputError: No depth camera sees enough of it.
    """
    first = viewpoint_of(place, cell)
    return (first, *aslant_viewpoints(first, place, empty_scene(cell)))


def aslant_viewpoints(first: Viewpoint, place: Place, believed: Scene) -> tuple[Viewpoint, ...]:
    """Turn a viewpoint to both sides about the vertical through the middle of the mouth of a place.

    Args:
        first: The viewpoint.
        place: The place.
        believed: A scene with the place where it is believed to be.

    Returns:
        Those of both from which enough of the place is seen, and where the arm keeps its clearance wherever
        the pod may stand; none if the arm does not move the camera.
    """
    if first.camera.link is None:
        return ()
    aside = (_turned(first, side, (angle, 0.0), (place, believed)) for side, angle in _SIDES)
    return tuple(
        each for each in aside if each is not None and _seen_from(each, place, believed) >= LEAST_SEEN
    )


def further_viewpoints(place: Place, believed: Scene) -> tuple[Viewpoint, ...]:
    """Choose more places from which a place can be looked into, where ``viewpoints_of`` is not enough.

    Args:
        place: The place.
        believed: A scene with the place where it is believed to be.

    Returns:
        From farther aside, from above and from below, where the arm is clear and enough of the place is seen,
        with some reserve for the error of the camera's mount; none if the arm does not move the camera.

    Raises:
        InputError: No depth camera sees enough of it.
    """
    first = viewpoint_of(place, believed.cell)
    if first.camera.link is None:
        return ()
    turned = (_turned(first, side, (angle, tilt), (place, believed)) for side, angle, tilt in _FURTHER)
    enough = LEAST_SEEN + _RESERVE
    return tuple(each for each in turned if each is not None and _seen_from(each, place, believed) >= enough)


def _stated_viewpoints(cell: Cell) -> Iterator[Viewpoint]:
    """Viewpoints of all depth cameras from all configurations of kind ``CAMERA_KIND``."""
    for at in cell.configurations.values():
        if at.kind == CAMERA_KIND:
            for camera in cell.cameras.values():
                if camera.model.depth is not None:
                    yield Viewpoint(camera, at, camera_pose(cell.robot, camera, at.q, at.tool_state))


def _turned(
    first: Viewpoint, side: str, by: tuple[float, float], of: tuple[Place, Scene]
) -> Viewpoint | None:
    """A viewpoint turned about the mouth of a place, by the configuration nearest to the first one's.

    by: about the vertical, then about the camera's own horizontal axis
    """
    (place, scene), cell, at = of, of[1].cell, first.at
    mouth = (scene.T_world_place(place) @ place.access.T_place_mouth)[:3, 3]
    R = rotation_axis_angle((0.0, 0.0, 1.0), by[0])
    R = rotation_axis_angle(R @ first.T_world_camera[:3, 0], by[1]) @ R
    T_world_camera = pose(mouth - R @ mouth, R=R) @ first.T_world_camera
    arm = Arm(cell.robot)
    T_camera_tip = inverse(first.T_world_camera) @ arm.tip(at.q, at.tool_state)
    anywhere = replace(empty_scene(cell), pod_error=cell.pod.displacement)
    checker = SceneChecker(CollisionModel(cell), anywhere, at.tool_state)
    for q in arm.solve(T_world_camera @ T_camera_tip, at.tool_state, at.q[None]):
        turned = Viewpoint(first.camera, replace(at, name=f"{at.name}_{side}", q=q), T_world_camera)
        if checker.is_valid(q):
            return turned
    return None


def _seen_from(viewpoint: Viewpoint, place: Place, scene: Scene) -> float:
    """Share of the room of a place that is in sight, were no items in it."""
    known = RenderedScene.of(replace(scene, items=()), viewpoint.at.q, viewpoint.at.tool_state)
    view = coarse_view(viewpoint.camera.model.camera, viewpoint.T_world_camera, known)
    return room_sight(view, known, place, scene.T_world_place(place)).seen
