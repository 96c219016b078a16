"""Where a camera of the cell looks from, as stated, and the pictures that it recorded."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.logs import stage
from pickcli.commands.options.common_options import of_file
from pickcli.commands.options.configuration_option import parse_start
from pickcli.commands.options.named_camera import named_camera

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.cell.sensors.mounted_camera import MountedCamera
    from pickcli.perception.camera_picture import CameraPicture
    from pickcli.perception.recorded_picture import RecordedPicture
    from pickcli.perception.viewpoints import Viewpoint
    from pickcli.planning.start_state import Start
    from pickcli.scene.scene import Scene


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


def named_viewpoint(cell: Cell, name: str, at: str) -> Viewpoint:
    """Find from where a camera looks.

    Args:
        cell: The cell.
        name: Name of the camera.
        at: Configuration of the arm, as it was stated.

    Returns:
        The viewpoint.

    Raises:
        InputError: The cell has no such camera or configuration.
    """
    from pickcli.perception.camera_picture import viewpoint_at

    camera, begin = named_camera(cell, name), parse_start(cell, at)
    return viewpoint_at(cell, camera, at, begin.q, begin.tool_state)


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
    from pickcli.cell.cell import NamedConfiguration
    from pickcli.errors import InputError
    from pickcli.perception.camera_picture import CameraPicture
    from pickcli.perception.items.rgbd_picture import RgbdPicture
    from pickcli.perception.recorded_picture import read_recording
    from pickcli.perception.viewpoints import CAMERA_KIND, Viewpoint

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
            at = NamedConfiguration(recording.at, begin.q, begin.tool_state, CAMERA_KIND)
            viewpoint = Viewpoint(camera, at, recording.T_world_camera)
            taken.append(CameraPicture(str(path), viewpoint, rgbd, files))
    first = taken[0].viewpoint.camera.name
    if others := {each.viewpoint.camera.name for each in taken} - {first}:
        raise InputError(
            f"{paths[0]}: is of camera {first}, another of {min(others)}; "
            "perceive what each camera took by itself"
        )
    return tuple(taken)
