"""From where the cameras of a cell look into a place: straight on, and aslant from both sides.

Looks from different places err differently: what hides an item, gives no depth or leaves a side in doubt in
one of them does not in another. And a camera that is off its stated pose sees things aside the other way
when it is turned, which tells the error of its mount from where things are.
"""

from __future__ import annotations

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
from pickcli.scene.scene import empty_scene

CAMERA_KIND = "camera"  # of named configurations in which cameras look
ASLANT = float(np.radians(20.0))  # turn of a camera about the vertical through the middle of a mouth
_SIDES = (("left", ASLANT), ("right", -ASLANT))


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
    for at in cell.configurations.values():
        if at.kind != CAMERA_KIND:
            continue
        for camera in cell.cameras.values():
            if camera.model.depth is None:
                continue
            T = camera_pose(cell.robot, camera, at.q, at.tool_state)
            viewpoint = Viewpoint(camera, at, T)
            seen = _seen_from(viewpoint, place, cell)
            if seen > most:
                most, best = seen, viewpoint
    if best is None:
        raise InputError(
            f"{place.name}: no depth camera of {cell.name} sees half of its room from a configuration of "
            f"kind {CAMERA_KIND}; state one (docs/formats/cell.md), or play with --perception noise"
        )
    return best


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
    if first.camera.link is None:
        return (first,)
    aside = (_turned(first, side, angle, (place, cell)) for side, angle in _SIDES)
    return (first, *(each for each in aside if each is not None))


def _turned(first: Viewpoint, side: str, angle: float, of: tuple[Place, Cell]) -> Viewpoint | None:
    """A viewpoint turned about the mouth of a place, by the configuration nearest to the first one's."""
    (place, cell), at = of, first.at
    mouth = (cell.T_world_place(place) @ place.access.T_place_mouth)[:3, 3]
    R = rotation_axis_angle((0.0, 0.0, 1.0), angle)
    T_world_camera = pose(mouth - R @ mouth, R=R) @ first.T_world_camera
    arm = Arm(cell.robot)
    T_camera_tip = inverse(first.T_world_camera) @ arm.tip(at.q, at.tool_state)
    anywhere = replace(empty_scene(cell), pod_error=cell.pod.displacement)
    checker = SceneChecker(CollisionModel(cell), anywhere, at.tool_state)
    for q in arm.solve(T_world_camera @ T_camera_tip, at.tool_state, at.q[None]):
        turned = Viewpoint(first.camera, replace(at, name=f"{at.name}_{side}", q=q), T_world_camera)
        if checker.is_valid(q) and _seen_from(turned, place, cell) >= LEAST_SEEN:
            return turned
    return None


def _seen_from(viewpoint: Viewpoint, place: Place, cell: Cell) -> float:
    """Share of the room of a place that is in sight."""
    known = RenderedScene.of(empty_scene(cell), viewpoint.at.q, viewpoint.at.tool_state)
    view = coarse_view(viewpoint.camera.model.camera, viewpoint.T_world_camera, known)
    return room_sight(view, known, place, cell.T_world_place(place)).seen
