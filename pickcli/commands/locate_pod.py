"""``apc locate-pod``: where the pod stands, from one depth picture of a camera of the cell."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.arm_options import ArmRequest, arm_option, standing_option
from pickcli.commands.options.camera_pictures import mounted, refuse_half
from pickcli.commands.options.common_options import (
    json_option,
    output_option,
    refuse_output,
    refuse_reading,
    seed_option,
)
from pickcli.commands.options.configuration_option import parse_start
from pickcli.commands.options.named_camera import named_camera, optional_camera_options
from pickcli.commands.options.option_types import PATH, FiniteRange, refuse_suffix
from pickcli.commands.options.scene_options import scene_or_empty, scene_or_recorded_options
from pickcli.commands.output.perceived_lines import pod_lines
from pickcli.errors import InputError

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.cell.sensors.mounted_camera import MountedCamera
    from pickcli.geometry import Array
    from pickcli.perception.depth_picture import DepthPicture
    from pickcli.perception.pod_pose import PodEstimate
    from pickcli.planning.start_state import Start
    from pickcli.scene.scene import Scene


@click.command("locate-pod", cls=Command)
@scene_or_recorded_options
@optional_camera_options
@click.option("--recorded", "recorded", type=PATH, metavar="FILE",
              help="Depth that the camera recorded there: a PNG of 16 bits, 0 for nothing; or a recording "
                   "with intrinsics and pose (.json, see apc render --recording).  "
                   "[default: rendered of the scene, with the noise of the sensor]")  # fmt: skip
@click.option("--depth-step", "step_mm", type=FiniteRange(0.001, 10.0), default=0.1, show_default=True,
              metavar="MM", help="What one step of a recorded depth is.")  # fmt: skip
@output_option("pose")
@arm_option("the preferred one of those that have the configuration")
@standing_option
@seed_option
@json_option
def command(
    scene_path: Path | None, cell_name: str | None, items_path: Path | None, name: str | None, at: str | None,
    recorded: Path | None, step_mm: float, output: Path, arm: str | None, standing: tuple[str, ...],
    seed: int, overwrite: bool, as_json: bool,
) -> None:  # fmt: skip
    """Estimate where the pod stands from one depth picture, with bounds of the error.

    The camera sees the scene in depth with the noise of its sensor, or its depth was recorded. Where the
    pod stands, anywhere in its tolerance, follows from the picture alone. The bounds hold the error of
    the camera's pose that the cell states; a recorded depth that is off as a whole is not in them. The
    file is for apc believe and apc perceive.

    \b
    Example:
      apc locate-pod --scene scene.json --camera hand --at cam_E -o pod.json
      apc locate-pod --scene scene.json --camera hand --at cam_E -o pod.json --overwrite --json
      apc locate-pod --cell apc2016_delft --recorded e.json -o pod.json
    """
    from pickcli.perception.camera_pose import camera_pose
    from pickcli.perception.depth_picture import DepthPicture, read_depth
    from pickcli.perception.items.perceived_file import Perceived, perceived_values, write_perceived
    from pickcli.perception.perception_versions import perception_versions
    from pickcli.perception.pod_pose import locate_pod
    from pickcli.perception.recorded_picture import read_recording

    refuse_output(output, overwrite, scene_path, cell_name, items_path, recorded)
    refuse_suffix(output, (".json",), "the pose of a pod")
    if scene_path is None and recorded is None:
        raise click.UsageError("nothing to look at: name a scene with --scene, or a picture with --recorded")
    described = recorded if recorded is not None and _is_recording(recorded) else None
    refuse_half(name, at, (described,) if described else ())
    recording = None if described is None else read_recording(described)
    at = (at or "home") if recording is None else recording.at
    arms = ArmRequest(arm, standing, (at,), items=items_path, camera=name)
    scene = scene_or_empty(scene_path, cell_name, arms)
    if recording is not None:
        camera, begin = mounted(scene, recording)
        refuse_reading(output, recording.colour, recording.depth)
    else:
        assert name is not None  # as refuse_half saw to
        camera, begin = named_camera(scene.cell, name), parse_start(scene.cell, at)
    noise = camera.model.depth
    if noise is None:
        what = f"{camera.model.name} measures no depth, by which the pod is located"
        raise InputError(f"camera {camera.name}: {what}; choose another")
    T_world_camera = camera_pose(scene.cell.robot, camera, begin.q, begin.tool_state)
    if recording is not None:
        picture = recording.depth_picture(camera.model)
    elif recorded is None:
        picture = _rendered(scene, camera, begin, T_world_camera, seed)
    else:
        picture = DepthPicture(camera.model.camera, T_world_camera, read_depth(recorded, 1e-3 * step_mm))
    try:
        with stage("locating of the pod"):
            pod = locate_pod(picture, scene.cell, noise, camera.error)
    except InputError as error:
        if recorded is None:
            raise
        raise InputError(f"{recorded}: {error}") from None
    perceived = Perceived(
        scene.cell.name, camera.name, camera.model.name, picture.T_world_camera, (), pod,
        versions=perception_versions(()),
    )  # fmt: skip
    write_perceived(perceived, output, overwrite)
    x, y, yaw = _displacement(pod, scene.cell)
    if as_json:
        off = {"x": x, "y": y, "yaw": yaw}
        emit_json({**perceived_values(perceived), "displacement": off, "path": str(output), "seed": seed})
        return
    for line in pod_lines(pod, scene.cell):
        click.echo(line)
    click.echo(f"pose: {output}")


def _is_recording(path: Path) -> bool:
    """Whether a file describes a recording; all others are taken for pictures."""
    from pickcli.files.bounded_reading import read_kind
    from pickcli.files.file_kind import RECORDING

    return read_kind(path) is RECORDING


def _rendered(
    scene: Scene, camera: MountedCamera, begin: Start, T_world_camera: Array, seed: int
) -> DepthPicture:
    """What the camera sees of the scene."""
    from pickcli.perception.depth_picture import measure_depth
    from pickcli.perception.rendered_scene import RenderedScene

    with stage("rendering"):
        rendered = RenderedScene.of(scene, begin.q, begin.tool_state)
        return measure_depth(rendered, camera.model, T_world_camera, seed)


def _displacement(pod: PodEstimate, cell: Cell) -> tuple[float, float, float]:
    """By how much it is off its place in the cell: m, m and rad."""
    from pickcli.cell.pod_tolerance import yaw_of
    from pickcli.geometry import inverse

    T_nominal_pod = inverse(cell.T_world_pod) @ pod.T_world_pod
    return float(T_nominal_pod[0, 3]), float(T_nominal_pod[1, 3]), yaw_of(T_nominal_pod)
