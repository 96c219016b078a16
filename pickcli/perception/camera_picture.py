"""A picture in depth and colour with where it was taken: simulated in a scene, or recorded."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pickcli.cell.cell import Cell, NamedConfiguration
from pickcli.cell.place import Place
from pickcli.cell.sensors.mounted_camera import MountedCamera
from pickcli.cell.tool import ToolState
from pickcli.errors import InputError
from pickcli.geometry import Array
from pickcli.perception.camera_pose import camera_pose
from pickcli.perception.depth_picture import measure_depth
from pickcli.perception.items.rgbd_picture import RgbdPicture
from pickcli.perception.looks import colour_picture
from pickcli.perception.rendered_scene import RenderedScene
from pickcli.perception.viewpoints import CAMERA_KIND, Viewpoint, aslant_viewpoints
from pickcli.scene.scene import Scene
from pickcli.seeds import derived_seed


@dataclass(frozen=True)
class PictureSeeds:
    """Seeds of a simulated picture.

    Attributes:
        textures: Of the prints on the items.
        noise: Of the noise.
        is_deformed: Whether cloth and bags look other than their boxes.
    """

    textures: int = 1
    noise: int = 0
    is_deformed: bool = False


@dataclass(frozen=True, eq=False)
class CameraPicture:
    """A picture with where it was taken.

    Attributes:
        where: The camera and the configuration, or the file, for messages.
        viewpoint: The camera, the configuration of the arm and the stated pose.
        rgbd: The picture.
        files: The files that it was read from; none if it was simulated.
    """

    where: str
    viewpoint: Viewpoint
    rgbd: RgbdPicture
    files: tuple[Path, ...] = ()

    @property
    def is_recorded(self) -> bool:
        """Whether it was read from files."""
        return bool(self.files)


def viewpoint_at(cell: Cell, camera: MountedCamera, at: str, q: Array, tool_state: ToolState) -> Viewpoint:
    """Return from where a camera looks.

    Args:
        cell: The cell.
        camera: The camera.
        at: Name of the configuration, or as it was stated.
        q: (n,) configuration of the arm, m and rad.
        tool_state: State of the tool.

    Returns:
        The viewpoint.
    """
    T_world_camera = camera_pose(cell.robot, camera, q, tool_state)
    return Viewpoint(camera, NamedConfiguration(at, q, tool_state, CAMERA_KIND), T_world_camera)


def taken_picture(scene: Scene, viewpoint: Viewpoint, where: str, seeds: PictureSeeds) -> CameraPicture:
    """Take a picture of a scene, with the noise of the sensor.

    Args:
        scene: The scene.
        viewpoint: From where.
        where: The same, for messages.
        seeds: Of all that is random in it.

    Returns:
        The picture; the same bytes for the same arguments.

    Raises:
        InputError: The camera measures no depth, or nothing is measured.
    """
    camera, at, model = viewpoint.camera, viewpoint.at, viewpoint.camera.model
    if model.depth is None:
        raise InputError(
            f"camera {camera.name}: {model.name} measures no depth, by which items are found; choose another"
        )
    T_world_camera = viewpoint.T_world_camera
    rendered = RenderedScene.of(scene, at.q, at.tool_state, seeds.textures if seeds.is_deformed else None)
    depth = measure_depth(rendered, model, T_world_camera, seeds.noise).depth
    if not np.isfinite(depth).any():
        raise InputError(
            f"{where}: nothing is measured in any pixel; {model.name} measures from "
            f"{model.depth.least:g} to {model.depth.greatest:g} m; look from before a place"
        )
    colour = colour_picture(rendered, model.camera, T_world_camera, seeds.textures)
    return CameraPicture(where, viewpoint, RgbdPicture(model, T_world_camera, depth, colour))


def aslant_pictures(
    scene: Scene, first: CameraPicture, place: Place, believed: Scene, seeds: PictureSeeds
) -> tuple[CameraPicture, ...]:
    """Take pictures of a place from both sides.

    Args:
        scene: The scene.
        first: A picture of it straight on.
        place: The place.
        believed: A scene with the place where it is believed to be.
        seeds: Of all that is random in the first one.

    Returns:
        The pictures: two, but where the arm would not be clear, or too little would be seen.

    Raises:
        InputError: No arm moves the camera, or nothing is measured.
    """
    straight = first.viewpoint
    if straight.camera.link is None:
        raise InputError(f"camera {straight.camera.name}: no arm moves it, so it does not look aslant")
    named = replace(straight, at=replace(straight.at, name=place.name))
    taken = []
    for each in aslant_viewpoints(named, place, believed):
        T_world_camera = camera_pose(scene.cell.robot, each.camera, each.at.q, each.at.tool_state)
        noise = derived_seed("look", seeds.noise, each.at.name)
        where = f"{first.where}, {each.at.name}"
        there = replace(each, T_world_camera=T_world_camera)
        taken.append(taken_picture(scene, there, where, replace(seeds, noise=noise)))
    return tuple(taken)
