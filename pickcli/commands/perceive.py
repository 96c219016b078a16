"""``apc perceive``: poses of the items of bins from one look of a camera of the cell."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.arm_options import ArmRequest, arm_option, standing_option
from pickcli.commands.command import Command, emit_json
from pickcli.commands.configuration_option import parse_start
from pickcli.commands.logs import stage
from pickcli.commands.named_camera import camera_options, named_camera
from pickcli.commands.option_types import PATH, refuse_suffix
from pickcli.commands.options import json_option, output_option, refuse_output, refuse_same, seed_option
from pickcli.commands.perceived_lines import perceived_lines
from pickcli.commands.scene_options import open_scene, scene_options

if TYPE_CHECKING:
    from pickcli.cell.place import Place
    from pickcli.cell.sensors.mounted_camera import MountedCamera
    from pickcli.perception.items.item_observation import PlaceObservation
    from pickcli.perception.items.rgbd_picture import RgbdPicture
    from pickcli.perception.rendered_scene import RenderedScene
    from pickcli.planning.start_state import Start
    from pickcli.scene.scene import Scene


@click.command("perceive", cls=Command)
@scene_options
@camera_options
@click.option("--bin", "bin_names", metavar="PLACE", multiple=True,
              help="Bin, or other place, whose items are looked for; may be repeated.  "
                   "[default: all with items whose room is seen at least to half]")  # fmt: skip
@click.option("--pod", "pod_path", type=PATH, metavar="FILE",
              help="Where the pod was located (see apc locate-pod).  "
                   "[default: where the scene has it]")  # fmt: skip
@output_option("answers")
@click.option("--picture", "picture_path", type=PATH, metavar="FILE.png",
              help="Where to write the colour picture with the answers drawn over it.")  # fmt: skip
@click.option("--textures", "texture_seed", type=click.IntRange(0, 2**31 - 1), default=1, show_default=True,
              metavar="N", help="Which set of prints the items have; models know set 0.")  # fmt: skip
@arm_option("the preferred one of those that have the configuration")
@standing_option
@seed_option
@json_option
def command(
    scene_path: Path, cell_name: str | None, items_path: Path | None, name: str, at: str,
    bin_names: tuple[str, ...], pod_path: Path | None, output: Path, picture_path: Path | None,
    texture_seed: int, arm: str | None, standing: tuple[str, ...], seed: int, overwrite: bool, as_json: bool,
) -> None:  # fmt: skip
    """Find the listed items of bins in one look of a camera.

    The camera sees the scene in colour and in depth with the noise of its sensor. What is in each bin is
    known by name, as an order says; where it is follows from the picture alone. Each answer has a pose and a
    confidence, and is refused with a reason where that is too low.

    \b
    Example:
      apc perceive --scene scene.json --camera hand --at cam_E -o perceived.json
      apc perceive --scene scene.json --camera hand --at cam_E -o perceived.json --picture perceived.png
      apc perceive --scene scene.json --camera hand --at cam_E --bin bin_E -o perceived.json --json
      apc perceive --scene scene.json --camera hand --at cam_E --pod pod.json -o perceived.json
    """
    from pickcli.files.png_file import write_png
    from pickcli.perception.items.perceived_file import Perceived, perceived_values, write_perceived
    from pickcli.perception.perceived_picture import perceived_picture
    from pickcli.perception.rendered_scene import RenderedScene

    refuse_output(output, overwrite, scene_path, cell_name, items_path, pod_path)
    refuse_suffix(output, (".json",), "a file of perceived items")
    if picture_path is not None:
        refuse_output(picture_path, overwrite, scene_path, cell_name, items_path, pod_path)
        refuse_suffix(picture_path, (".png",), "a picture")
        refuse_same(output, picture_path)
    scene = open_scene(scene_path, cell_name, ArmRequest(arm, standing, (at,), items=items_path, camera=name))
    camera, begin = named_camera(scene.cell, name), parse_start(scene.cell, at)
    where = f"camera {name} at {at}"
    rgbd = _rgbd(scene, where, (camera, begin), (texture_seed, seed))
    if pod_path is not None:
        scene = _with_pod(scene, pod_path)
    known = RenderedScene.of(replace(scene, items=()), begin.q, begin.tool_state)
    places = _places(scene, bin_names, rgbd, known, where)
    with stage("perception"):
        found = tuple(_perceived(scene, rgbd, place, known) for place in places)
    perceived = Perceived(scene.cell.name, camera.name, camera.model.name, rgbd.T_world_camera, found)
    write_perceived(perceived, output, overwrite)
    if picture_path is not None:
        write_png(perceived_picture(rgbd, known, perceived), picture_path, overwrite)
    if as_json:
        drawn = {} if picture_path is None else {"picture": str(picture_path)}
        emit_json({**perceived_values(perceived), "path": str(output), **drawn, "seed": seed})
        return
    for each in found:
        for line in perceived_lines(each):
            click.echo(line)
    click.echo(f"answers: {output}")
    if picture_path is not None:
        click.echo(f"picture: {picture_path}")


def _with_pod(scene: Scene, path: Path) -> Scene:
    """The scene with the pod where a picture says."""
    from pickcli.errors import InputError
    from pickcli.perception.items.perceived_file import read_perceived

    perceived = read_perceived(path, scene.cell)
    if perceived.cell != scene.cell.name:
        raise InputError(
            f"{path}: is of cell {perceived.cell}, not of {scene.cell.name}; locate the pod again"
        )
    if perceived.pod is None:
        raise InputError(f"{path}: the pod was not located in it; apc locate-pod writes such a file")
    return replace(scene, T_world_pod=perceived.pod.T_world_pod, pod_error=perceived.pod.error)


def _rgbd(scene: Scene, where: str, at: tuple[MountedCamera, Start], seeds: tuple[int, int]) -> RgbdPicture:
    """What the camera sees; seeds of prints and of noise."""
    import numpy as np

    from pickcli.errors import InputError
    from pickcli.perception.camera_pose import camera_pose
    from pickcli.perception.depth_picture import measure_depth
    from pickcli.perception.items.rgbd_picture import RgbdPicture
    from pickcli.perception.looks import colour_picture
    from pickcli.perception.rendered_scene import RenderedScene

    camera, begin = at
    model = camera.model
    if model.depth is None:
        raise InputError(
            f"camera {camera.name}: {model.name} measures no depth, by which items are found; choose another"
        )
    with stage("rendering"):
        T_world_camera = camera_pose(scene.cell.robot, camera, begin.q, begin.tool_state)
        rendered = RenderedScene.of(scene, begin.q, begin.tool_state)
        depth = measure_depth(rendered, model, T_world_camera, seeds[1]).depth
        if not np.isfinite(depth).any():
            raise InputError(
                f"{where}: nothing is measured in any pixel; {model.name} measures from "
                f"{model.depth.least:g} to {model.depth.greatest:g} m; move the arm with --at before a place"
            )
        colour = colour_picture(rendered, model.camera, T_world_camera, seeds[0])
        return RgbdPicture(model, T_world_camera, depth, colour)


def _places(
    scene: Scene, names: tuple[str, ...], rgbd: RgbdPicture, known: RenderedScene, where: str
) -> list[Place]:
    """The named places, or those that the picture shows enough of."""
    from pickcli.errors import InputError, UnknownNameError
    from pickcli.perception.items.room_sight import LEAST_SEEN, coarse_view, room_sight

    cell = scene.cell
    for name in names:
        if name not in cell.places:
            raise UnknownNameError("place", name, list(cell.places), "--bin")
    if names:
        return [cell.places[name] for name in dict.fromkeys(names)]
    view = coarse_view(rgbd.sensor.camera, rgbd.T_world_camera, known)
    sights = {
        place: room_sight(view, known, place, scene.T_world_place(place))
        for place in cell.places.values()
        if scene.in_location(place.name)
    }
    if not sights:
        raise InputError("the scene has no items in any place; name a place to look into with --bin")
    most = max(sights, key=lambda place: sights[place].seen)
    if not sights[most].is_enough:
        best = f"of {most.name}, the best of these, {sights[most].fault}" if sights[most].seen else ""
        raise InputError(
            f"{where}: shows less than {LEAST_SEEN:.0%} of the room of every place with items"
            f"{': ' * bool(best)}{best}; move the arm with --at before one"
        )
    return [place for place, sight in sights.items() if sight.is_enough]


def _perceived(scene: Scene, rgbd: RgbdPicture, place: Place, known: RenderedScene) -> PlaceObservation:
    from pickcli.perception.items.item_perception import ListedItem, perceive_items

    held = None if scene.held is None else scene.held.id
    listed = [ListedItem(each.id, each.item) for each in scene.in_location(place.name) if each.id != held]
    found = perceive_items(rgbd, place, scene.T_world_place(place), listed, known)
    return replace(found, error=scene.pose_of(scene.cell.carriers[place.carrier]).error)
