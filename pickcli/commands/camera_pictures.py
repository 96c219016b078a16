"""Pictures that a camera of the cell took: simulated in a scene, or recorded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.configuration_option import parse_start
from pickcli.commands.logs import stage
from pickcli.commands.named_camera import named_camera
from pickcli.commands.options import of_file

if TYPE_CHECKING:
    from pickcli.cell.place import Place
    from pickcli.cell.sensors.mounted_camera import MountedCamera
    from pickcli.perception.items.rgbd_picture import RgbdPicture
    from pickcli.perception.items.room_sight import RoomSight
    from pickcli.perception.recorded_picture import RecordedPicture
    from pickcli.perception.rendered_scene import RenderedScene
    from pickcli.planning.start_state import Start
    from pickcli.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class CameraPicture:
    """A picture with where it was taken.

    Attributes:
        where: The camera and the configuration, or the file, for messages.
        camera: The camera.
        begin: The configuration of the arm.
        rgbd: The picture.
        files: The files that it was read from; none if it was simulated.
    """

    where: str
    camera: MountedCamera
    begin: Start
    rgbd: RgbdPicture
    files: tuple[Path, ...] = ()

    @property
    def is_recorded(self) -> bool:
        """Whether it was read from files."""
        return bool(self.files)

    def known(self, scene: Scene) -> RenderedScene:
        """Return all that is known to be in it.

        Args:
            scene: A scene, for where its carriers are.

        Returns:
            The solids without items.
        """
        from pickcli.perception.rendered_scene import RenderedScene

        return RenderedScene.of(replace(scene, items=()), self.begin.q, self.begin.tool_state)

    def sight_of(self, scene: Scene, place: Place) -> RoomSight:
        """Compute how much of a place it shows.

        Args:
            scene: The scene, for where the place is.
            place: The place.

        Returns:
            The shares of its room.
        """
        from pickcli.perception.items.room_sight import coarse_view, room_sight

        known = self.known(scene)
        view = coarse_view(self.rgbd.sensor.camera, self.rgbd.T_world_camera, known)
        return room_sight(view, known, place, scene.T_world_place(place))


def refuse_half(name: str | None, at: str | None, recorded: Sequence[Path]) -> None:
    """Refuse neither a camera nor recordings, and both.

    Args:
        name: Name of the camera on the command line.
        at: Configuration of the arm on the command line.
        recorded: Files of recordings.

    Raises:
        UsageError: One of these.
    """
    if recorded and (name is not None or at is not None):
        option = "--camera" if name is not None else "--at"
        raise click.UsageError(f"a recording states its camera and where the arm was; leave {option} out")
    if not recorded and name is None:
        raise click.UsageError("no pictures: name a camera with --camera, or recordings with --recorded")


def simulated_picture(
    scene: Scene, name: str, at: str, seeds: tuple[int, int], is_deformed: bool = False
) -> CameraPicture:
    """Take a picture of a scene.

    Args:
        scene: The scene.
        name: Name of the camera.
        at: Configuration of the arm.
        seeds: Of the prints on the items, and of the noise.
        is_deformed: Whether cloth and bags look other than their boxes.

    Returns:
        The picture.

    Raises:
        InputError: The cell has no such camera or configuration, the camera measures no depth, or nothing is
            measured.
    """
    camera, begin = named_camera(scene.cell, name), parse_start(scene.cell, at)
    return _simulated(scene, (camera, begin), f"camera {name} at {at}", seeds, is_deformed)


def aslant_pictures(
    scene: Scene,
    first: CameraPicture,
    place: Place,
    believed: Scene,
    seeds: tuple[int, int],
    is_deformed: bool = False,
) -> tuple[CameraPicture, ...]:
    """Take pictures of a place from both sides.

    Args:
        scene: The scene.
        first: A picture of it straight on.
        place: The place.
        believed: A scene with the place where it is believed to be.
        seeds: Of the prints on the items, and of the noise.
        is_deformed: Whether cloth and bags look other than their boxes.

    Returns:
        The pictures: two, but where the arm would not be clear, or too little would be seen.
    """
    from pickcli.cell.cell import NamedConfiguration
    from pickcli.perception.viewpoints import CAMERA_KIND, Viewpoint, aslant_viewpoints
    from pickcli.seeds import derived_seed

    at = NamedConfiguration(place.name, first.begin.q, first.begin.tool_state, CAMERA_KIND)
    viewpoint = Viewpoint(first.camera, at, first.rgbd.T_world_camera)
    return tuple(
        _simulated(
            scene,
            (each.camera, replace(first.begin, q=each.at.q)),
            f"{first.where}, {each.at.name}",
            (seeds[0], derived_seed("look", seeds[1], each.at.name)),
            is_deformed,
        )
        for each in aslant_viewpoints(viewpoint, place, believed)
    )


def _simulated(
    scene: Scene, by: tuple[MountedCamera, Start], where: str, seeds: tuple[int, int], is_deformed: bool
) -> CameraPicture:
    """A picture of a scene by a camera in a configuration of the arm."""
    import numpy as np

    from pickcli.errors import InputError
    from pickcli.perception.camera_pose import camera_pose
    from pickcli.perception.depth_picture import measure_depth
    from pickcli.perception.items.rgbd_picture import RgbdPicture
    from pickcli.perception.looks import colour_picture
    from pickcli.perception.rendered_scene import RenderedScene

    (camera, begin), model = by, by[0].model
    if model.depth is None:
        raise InputError(
            f"camera {camera.name}: {model.name} measures no depth, by which items are found; choose another"
        )
    with stage("rendering"):
        T_world_camera = camera_pose(scene.cell.robot, camera, begin.q, begin.tool_state)
        rendered = RenderedScene.of(scene, begin.q, begin.tool_state, seeds[0] if is_deformed else None)
        depth = measure_depth(rendered, model, T_world_camera, seeds[1]).depth
        if not np.isfinite(depth).any():
            raise InputError(
                f"{where}: nothing is measured in any pixel; {model.name} measures from "
                f"{model.depth.least:g} to {model.depth.greatest:g} m; move the arm with --at before a place"
            )
        colour = colour_picture(rendered, model.camera, T_world_camera, seeds[0])
        rgbd = RgbdPicture(model, T_world_camera, depth, colour)
    return CameraPicture(where, camera, begin, rgbd)


def mounted(scene: Scene, recording: RecordedPicture) -> tuple[MountedCamera, Start]:
    """Find the camera of a recording, and where the arm was.

    Args:
        scene: A scene of the cell in which it was taken.
        recording: The recording.

    Returns:
        The camera with the intrinsics of the recording, and the state of the robot.

    Raises:
        InputError: It is of another cell or camera, its ``at`` is no configuration or is elsewhere.
    """
    from pickcli.perception.camera_pose import camera_pose

    camera = recording.mounted(scene.cell)
    with of_file(recording.path):
        begin = parse_start(scene.cell, recording.at)
    recording.refuse_elsewhere(camera_pose(scene.cell.robot, camera, begin.q, begin.tool_state))
    return camera, begin


def recorded_pictures(scene: Scene, paths: Sequence[Path]) -> tuple[CameraPicture, ...]:
    """Read recorded pictures.

    Args:
        scene: A scene of the cell in which they were taken.
        paths: Files of recordings.

    Returns:
        The pictures.

    Raises:
        InputError: A file cannot be read or has mistakes, is of another cell or camera, its pictures do not
            fit, or they are of several cameras.
    """
    from pickcli.errors import InputError
    from pickcli.perception.items.rgbd_picture import RgbdPicture
    from pickcli.perception.recorded_picture import read_recording

    taken = []
    with stage("reading of the pictures"):
        for path in paths:
            recording = read_recording(path)
            camera, begin = mounted(scene, recording)
            if camera.model.depth is None:
                raise InputError(
                    f"{path}: camera {camera.name}: {camera.model.name} measures no depth, by which items "
                    "are found; choose another"
                )
            depth, colour = recording.depth_picture(camera.model), recording.colour_picture()
            rgbd = RgbdPicture(camera.model, recording.T_world_camera, depth.depth, colour)
            files = (path, recording.colour, recording.depth)
            taken.append(CameraPicture(str(path), camera, begin, rgbd, files))
    if others := {each.camera.name for each in taken} - {taken[0].camera.name}:
        raise InputError(
            f"{paths[0]}: is of camera {taken[0].camera.name}, another of {min(others)}; "
            "perceive what each camera took by itself"
        )
    return tuple(taken)
