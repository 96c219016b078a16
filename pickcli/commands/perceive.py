"""``apc perceive``: poses of the items of bins from one look of a camera of the cell."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.arm_options import ArmRequest, arm_option, standing_option
from pickcli.commands.command import Command, emit_json
from pickcli.commands.configuration_option import CONFIGURATION, CONFIGURATION_HELP, parse_start
from pickcli.commands.logs import stage
from pickcli.commands.named_camera import named_camera
from pickcli.commands.option_types import refuse_suffix
from pickcli.commands.options import json_option, output_option, refuse_output, seed_option
from pickcli.commands.scene_options import open_scene, scene_options
from pickcli.commands.table import table_lines

if TYPE_CHECKING:
    from pickcli.cell.place import Place
    from pickcli.cell.tool import ToolState
    from pickcli.geometry import Array
    from pickcli.perception.items.item_observation import ItemObservation, PlaceObservation
    from pickcli.perception.items.rgbd_picture import RgbdPicture
    from pickcli.scene.scene import Scene

_LEAST_SHARE = 0.5  # of a mouth, for a place that is not named


@click.command("perceive", cls=Command)
@scene_options
@click.option("--camera", "name", metavar="NAME", required=True,
              help="A camera under sensors of the cell (apc inspect lists them).")  # fmt: skip
@click.option("--at", "at", metavar=CONFIGURATION, default="home", show_default=True,
              help=f"Where the arm is: {CONFIGURATION_HELP}")  # fmt: skip
@click.option("--bin", "bin_names", metavar="PLACE", multiple=True,
              help="Bin, or other place, whose items are looked for; may be repeated.  "
                   "[default: all of whose mouth more than half is in the picture]")  # fmt: skip
@output_option("answers")
@click.option("--textures", "texture_seed", type=click.IntRange(0, 2**31 - 1), default=1, show_default=True,
              metavar="N", help="Which set of prints the items have; models know set 0.")  # fmt: skip
@arm_option("the preferred one of those that have the configuration")
@standing_option
@seed_option
@json_option
def command(
    scene_path: Path, cell_name: str | None, items_path: Path | None, name: str, at: str,
    bin_names: tuple[str, ...], output: Path, texture_seed: int, arm: str | None, standing: tuple[str, ...],
    seed: int, overwrite: bool, as_json: bool,
) -> None:  # fmt: skip
    """Find the listed items of bins in one look of a camera.

    The camera sees the scene in colour and in depth with the noise of its sensor. What is in each bin is
    known by name, as an order says; where it is follows from the picture alone. Each answer has a pose and a
    confidence, and is refused with a reason where that is too low.

    \b
    Example:
      apc perceive --scene scene.json --camera hand --at cam_E -o perceived.json
      apc perceive --scene scene.json --camera hand --at cam_E --bin bin_E -o perceived.json --json
    """
    from pickcli.perception.items.perceived_file import Perceived, perceived_values, write_perceived

    refuse_output(output, overwrite, scene_path, cell_name, items_path)
    refuse_suffix(output, (".json",), "a file of perceived items")
    scene = open_scene(scene_path, cell_name, ArmRequest(arm, standing, (at,), items=items_path))
    camera, begin = named_camera(scene.cell, name), parse_start(scene.cell, at)
    rgbd = _rgbd(scene, name, begin.q, begin.tool_state, (texture_seed, seed))
    places = _places(scene, bin_names, rgbd, f"{name} at {at}")
    with stage("perception"):
        found = tuple(_perceived(scene, begin.q, begin.tool_state, rgbd, place) for place in places)
    perceived = Perceived(scene.cell.name, camera.name, camera.model.name, rgbd.T_world_camera, found)
    write_perceived(perceived, output, overwrite)
    if as_json:
        emit_json({**perceived_values(perceived), "path": str(output), "seed": seed})
        return
    for each in found:
        _tell(each)
    click.echo(f"answers: {output}")


def _rgbd(scene: Scene, name: str, q: Array, tool_state: ToolState, seeds: tuple[int, int]) -> RgbdPicture:
    """What the camera sees; seeds of prints and of noise."""
    from pickcli.errors import InputError
    from pickcli.perception.camera_pose import camera_pose
    from pickcli.perception.depth_picture import measure_depth
    from pickcli.perception.items.rgbd_picture import RgbdPicture
    from pickcli.perception.looks import colour_picture
    from pickcli.perception.rendered_scene import RenderedScene

    camera = scene.cell.cameras[name]
    if camera.model.depth is None:
        raise InputError(
            f"camera {name}: {camera.model.name} measures no depth, by which items are found; choose another"
        )
    with stage("rendering"):
        T_world_camera = camera_pose(scene.cell.robot, camera, q, tool_state)
        rendered = RenderedScene.of(scene, q, tool_state)
        depth = measure_depth(rendered, camera.model, T_world_camera, seeds[1]).depth
        colour = colour_picture(rendered, camera.model.camera, T_world_camera, seeds[0])
        return RgbdPicture(camera.model, T_world_camera, depth, colour)


def _places(scene: Scene, names: tuple[str, ...], rgbd: RgbdPicture, where: str) -> list[Place]:
    """The named places, or those that the picture shows."""
    from pickcli.errors import InputError, UnknownNameError
    from pickcli.perception.items.place_view import mouth_in_picture

    cell = scene.cell
    for name in names:
        if name not in cell.places:
            raise UnknownNameError("place", name, list(cell.places), "--bin")
    places = [cell.places[name] for name in dict.fromkeys(names)]
    if places:
        return places
    camera = rgbd.sensor.camera
    for place in cell.places.values():
        T_world_place = scene.T_world_place(place)
        share = mouth_in_picture(camera, rgbd.T_world_camera, place, T_world_place)
        if scene.in_location(place.name) and share > _LEAST_SHARE:
            places.append(place)
    if not places:
        raise InputError(
            f"{where}: shows less than half of the mouth of every place with items; move the arm with --at "
            "before one, or name one with --bin"
        )
    return places


def _perceived(
    scene: Scene, q: Array, tool_state: ToolState, rgbd: RgbdPicture, place: Place
) -> PlaceObservation:
    from pickcli.perception.items.item_perception import ListedItem, perceive_items
    from pickcli.perception.rendered_scene import RenderedScene

    held = None if scene.held is None else scene.held.id
    listed = [ListedItem(each.id, each.item) for each in scene.in_location(place.name) if each.id != held]
    known = RenderedScene.of(replace(scene, items=()), q, tool_state)
    return perceive_items(rgbd, place, scene.T_world_place(place), listed, known)


def _tell(observed: PlaceObservation) -> None:
    answered = sum(item.is_answer for item in observed.items)
    click.echo(f"{observed.place}: {answered} of {len(observed.items)} listed items found")
    rows = [
        [item.id, f"{item.confidence:.2f}", _bound(item), item.refusal or _position(item.T_world_item)]
        for item in observed.items
    ]
    for line in table_lines(["item", "confidence", "within", "position in m, or why not"], rows):
        click.echo(f"  {line}")
    if observed.has_unlisted:
        size = " x ".join(
            f"{1e3 * v:.0f}" for v in observed.unexplained[0].high - observed.unexplained[0].low
        )
        click.echo(f"  something of {size} mm is there that is not listed")


def _bound(item: ItemObservation) -> str:
    return f"{1e3 * item.bound.position:.1f} mm" if item.bound is not None and item.is_answer else ""


def _position(T: Array | None) -> str:
    return "" if T is None else " ".join(f"{v:.3f}" for v in T[:3, 3])
