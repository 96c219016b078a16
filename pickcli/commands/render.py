"""``apc render``: pictures of a scene by a camera of the cell."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.arm_options import ArmRequest, arm_option, standing_option
from pickcli.commands.options.common_options import (
    json_option,
    overwrite_option,
    refuse_output,
    refuse_same,
    seed_option,
)
from pickcli.commands.options.configuration_option import parse_start
from pickcli.commands.options.named_camera import camera_options, deformed_option, named_camera
from pickcli.commands.options.option_types import PATH, refuse_suffix
from pickcli.commands.options.scene_options import open_scene, scene_options
from pickcli.errors import InputError

if TYPE_CHECKING:
    from pickcli.cell.sensors.mounted_camera import MountedCamera
    from pickcli.perception.depth_picture import DepthPicture
    from pickcli.perception.rendered_scene import RenderedScene
    from pickcli.perception.surface_view import SurfaceView

_PNG = (".png",)


@click.command("render", cls=Command)
@scene_options
@camera_options
@click.option("-o", "--output", type=PATH, metavar="FILE.png", help="Where to write the colour picture.")
@click.option("--depth", "depth_path", type=PATH, metavar="FILE.png",
              help="Where to write the depth: 16 bits, in steps of 0.1 mm, 0 for nothing.")  # fmt: skip
@click.option("--recording", "recording_path", type=PATH, metavar="FILE.json",
              help="Where to write intrinsics and pose beside both pictures, for apc perceive "
                   "--recorded.")  # fmt: skip
@click.option("--noise/--no-noise", "is_noisy", default=True, show_default=True,
              help="Whether depth has the noise of the sensor.")  # fmt: skip
@click.option("--textures", "texture_seed", type=click.IntRange(0, 2**31 - 1), default=0, show_default=True,
              metavar="N", help="Which set of prints the items have.")  # fmt: skip
@deformed_option("by the seed of --textures")
@arm_option("the preferred one of those that have the configuration")
@standing_option
@seed_option
@overwrite_option
@json_option
def command(
    scene_path: Path, cell_name: str | None, items_path: Path | None, name: str, at: str, output: Path | None,
    depth_path: Path | None, recording_path: Path | None, is_noisy: bool, texture_seed: int,
    is_deformed: bool, arm: str | None, standing: tuple[str, ...], seed: int, overwrite: bool, as_json: bool,
) -> None:  # fmt: skip
    """Render what a camera of the cell sees of a scene.

    The colour picture shows items with prints of their own, under a lamp in the hall and a light at the
    camera. Depth is along the optical axis, with the noise of the sensor. --json prints intrinsics and pose
    of the camera, and how many pixels show each item. --recording writes what apc perceive needs to read both
    pictures again, as it reads those that a real camera took.

    \b
    Example:
      apc render --scene scene.json --camera hand --at cam_E -o bin_E.png --depth bin_E_depth.png
      apc render --scene scene.json --camera boom --depth tote.png --no-noise
      apc render --scene scene.json --camera hand --at cam_E -o e.png --depth e_depth.png --recording e.json
    """
    from pickcli.files.png_file import write_png
    from pickcli.perception.camera_pose import camera_pose
    from pickcli.perception.looks import colour_picture
    from pickcli.perception.recorded_picture import recording_values, write_recording
    from pickcli.perception.rendered_scene import RenderedScene

    outputs = [path for path in (output, depth_path) if path is not None]
    if not outputs:
        raise click.UsageError(
            "nothing to write: name a colour picture with -o, or one of depth with --depth"
        )
    for path in outputs:
        refuse_output(path, overwrite, scene_path, cell_name, items_path)
        refuse_suffix(path, _PNG, "a picture")
    if recording_path is not None:
        if output is None or depth_path is None:
            raise click.UsageError("a recording has both pictures: name the colour one with -o, --depth too")
        refuse_output(recording_path, overwrite, scene_path, cell_name, items_path)
        refuse_suffix(recording_path, (".json",), "a recording")
    refuse_same(*outputs, *([] if recording_path is None else [recording_path]))
    scene = open_scene(scene_path, cell_name, ArmRequest(arm, standing, (at,), items=items_path, camera=name))
    camera, begin = named_camera(scene.cell, name), parse_start(scene.cell, at)
    T_world_camera = camera_pose(scene.cell.robot, camera, begin.q, begin.tool_state)
    rendered = RenderedScene.of(scene, begin.q, begin.tool_state, texture_seed if is_deformed else None)
    view = rendered.seen_by(camera.model.camera, T_world_camera)
    depth = None if depth_path is None else _depth(rendered, camera, view, seed if is_noisy else None)
    with stage("rendering"):
        if output is not None:
            picture = colour_picture(rendered, camera.model.camera, T_world_camera, texture_seed)
            write_png(picture, output, overwrite)
        if depth_path is not None and depth is not None:
            write_png(depth.in_steps, depth_path, overwrite)
    if recording_path is not None and output is not None and depth_path is not None:
        of, pictures = (scene.cell, camera), (output, depth_path)
        values = recording_values(of, at, T_world_camera, pictures, recording_path)
        write_recording(values, recording_path, overwrite)
    summary = _summary(rendered, camera, view, depth)
    if as_json:
        emit_json({**summary, **{key: None if path is None else str(path)
                                 for key, path in (("path", output), ("depth_path", depth_path),
                              ("recording", recording_path))},
                   "seed": seed})  # fmt: skip
    else:
        items = summary["items"]
        click.echo(
            f"{len(items)} item{'s' * (len(items) != 1)} in sight of {camera.name} ({camera.model.name})"
        )
        for path in outputs:
            click.echo(f"{'picture' if path is output else 'depth'}: {path}")
        if recording_path is not None:
            click.echo(f"recording: {recording_path}")


def _depth(
    rendered: RenderedScene, camera: MountedCamera, view: SurfaceView, seed: int | None
) -> DepthPicture:
    """Depth by the sensor, or without a seed the true one."""
    from pickcli.perception.depth_picture import DepthPicture, measure_depth

    if seed is None:
        return DepthPicture(view.camera, view.T_world_camera, view.depth)
    if camera.model.depth is None:
        raise InputError(
            f"camera {camera.name}: {camera.model.name} is a colour camera, which measures no depth; "
            "--no-noise writes the true depth, or choose another"
        )
    return measure_depth(rendered, camera.model, view.T_world_camera, seed)


def _summary(
    rendered: RenderedScene, camera: MountedCamera, view: SurfaceView, depth: DepthPicture | None
) -> dict[str, Any]:
    from collections import Counter

    import numpy as np

    from pickcli.perception.rendered_scene import OwnerKind

    counts = np.bincount(view.index[view.index >= 0], minlength=len(rendered.solids)).tolist()
    solids = zip(rendered.solids, counts, strict=True)
    pixels = Counter[str]()
    for each, n in solids:
        if each.kind is OwnerKind.ITEM and n > 0:
            pixels[each.owner] += n
    return {
        "camera": camera.name,
        "sensor": camera.model.name,
        "size": [view.camera.width, view.camera.height],
        "K": view.camera.K.tolist(),
        "T_world_camera": view.T_world_camera.tolist(),
        "items": dict(pixels),
        "measured_share": None if depth is None else float(np.isfinite(depth.depth).mean()),
    }
