"""``apc perceive``: poses of the items of bins from one look of a camera of the cell."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.arm_options import ArmRequest, arm_option, standing_option
from pickcli.commands.options.camera_pictures import named_viewpoint, recorded_pictures, refuse_half
from pickcli.commands.options.common_options import (
    advised,
    json_option,
    output_option,
    refuse_output,
    refuse_reading,
    refuse_same,
    seed_option,
)
from pickcli.commands.options.listed_contents import (
    bin_option,
    listed_contents,
    named_places,
    order_option,
)
from pickcli.commands.options.named_camera import (
    camera_or_recording_options,
    deformed_option,
    refuse_missing_opencv,
    sift_option,
)
from pickcli.commands.options.option_types import PATH, refuse_suffix
from pickcli.commands.options.scene_options import scene_or_empty, scene_or_recorded_options
from pickcli.commands.output.perceived_lines import perceived_lines

if TYPE_CHECKING:
    from pickcli.perception.textures.sift_views import SiftRule
    from pickcli.scene.scene import Scene


@click.command("perceive", cls=Command)
@scene_or_recorded_options
@order_option
@camera_or_recording_options
@click.option("--aslant", "is_aslant", is_flag=True,
              help="Let the camera look into each place from both sides, too, by 20 "
                   "degrees.")  # fmt: skip
@bin_option
@click.option("--pod", "pod_path", type=PATH, metavar="FILE",
              help="Where the pod was located (see apc locate-pod).  "
                   "[default: where the scene has it]")  # fmt: skip
@output_option("answers")
@click.option("--picture", "picture_path", type=PATH, metavar="FILE.png",
              help="Where to write the colour picture with the answers drawn over it.")  # fmt: skip
@click.option("--textures", "texture_seed", type=click.IntRange(0, 2**31 - 1), default=1, show_default=True,
              metavar="N", help="Which set of prints the items have; models know set 0, those of prints this "
                                "one.")  # fmt: skip
@sift_option()
@deformed_option("and bounds of their poses allow for it")
@arm_option("the preferred one of those that have the configuration")
@standing_option
@seed_option
@json_option
def command(
    scene_path: Path | None, cell_name: str | None, items_path: Path | None, order_path: Path | None,
    name: str | None, at: str | None, recorded: tuple[Path, ...], is_aslant: bool, bin_names: tuple[str, ...],
    pod_path: Path | None, output: Path, picture_path: Path | None, texture_seed: int, sift: SiftRule,
    is_deformed: bool, arm: str | None, standing: tuple[str, ...], seed: int, overwrite: bool, as_json: bool,
) -> None:  # fmt: skip
    """Find the listed items of bins in pictures of a camera.

    The camera sees the scene in colour and in depth with the noise of its sensor, or its pictures were
    recorded; of several, answers are what looks from two places agree on. What is in each bin is known by
    name, as an order says; where it is follows from the pictures alone. Each answer has a pose and a
    confidence, and is refused with a reason where that is too low. A pose found by its print has the right
    side in front, where shapes alone leave open which of several like sides that is.

    \b
    Example:
      apc perceive --scene scene.json --camera hand --at cam_E -o perceived.json
      apc perceive --scene scene.json --camera hand --at cam_E -o drawn.json --picture drawn.png
      apc perceive --scene scene.json --camera hand --at cam_E --bin bin_E -o bin_E.json --json
      apc perceive --scene scene.json --camera hand --at cam_E --sift all-views -o printed.json
      apc perceive --scene scene.json --camera hand --at cam_E --aslant -o aslant.json
      apc perceive --scene scene.json --camera hand --at cam_E --pod pod.json -o in_pod.json
      apc perceive --order order.json --cell apc2016_delft --recorded e.json -o recorded.json
    """
    from pickcli.files.png_file import write_png
    from pickcli.perception.camera_picture import PictureSeeds, aslant_pictures, taken_picture
    from pickcli.perception.items.perceived_file import perceived_values, write_perceived
    from pickcli.perception.items.routing import PrintSearch
    from pickcli.perception.perceived_picture import perceived_picture
    from pickcli.perception.perceived_places import known_from, perceived_in, places_in_sight
    from pickcli.perception.recorded_picture import read_recording

    refuse_half(name, at, recorded)
    if recorded and is_aslant:
        raise click.UsageError("recordings are from where they are; leave --aslant out, and name several")
    inputs = (scene_path, cell_name, items_path, order_path, pod_path, *recorded)
    refuse_output(output, overwrite, *inputs)
    refuse_suffix(output, (".json",), "a file of perceived items")
    if picture_path is not None:
        refuse_output(picture_path, overwrite, *inputs)
        refuse_suffix(picture_path, (".png",), "a picture")
        refuse_same(output, picture_path)
    if not recorded and scene_path is None:
        raise click.UsageError("nothing to look at: name a scene with --scene, or pictures with --recorded")
    refuse_missing_opencv(sift)
    taken_at = [read_recording(path).at for path in recorded] or [at or "home"]
    arms = ArmRequest(arm, standing, tuple(dict.fromkeys(taken_at)), items=items_path, camera=name)
    scene = scene_or_empty(scene_path, cell_name, arms)
    contents = listed_contents(scene, order_path, is_deformed)
    seeds = PictureSeeds(texture_seed, seed, is_deformed)
    if recorded:
        taken = recorded_pictures(scene, recorded)
        for path in filter(None, (output, picture_path)):
            refuse_reading(path, *(file for each in taken for file in each.files))
    else:
        assert name is not None
        where = f"camera {name} at {at or 'home'}"
        with stage("rendering"):
            viewpoint = named_viewpoint(scene.cell, name, at or "home")
            with advised(" (--camera and --at say from where it is taken)"):
                taken = (taken_picture(scene, viewpoint, where, seeds),)
    true = scene
    if pod_path is not None:
        scene = _with_pod(scene, pod_path)
    advice = "take it" if recorded else "move the arm with --at"
    places = named_places(scene.cell, bin_names) or places_in_sight(
        scene, contents, {each.where: each.viewpoint for each in taken}, advice
    )
    first = taken[0]
    by_place = dict.fromkeys(places, taken)
    if is_aslant:
        with stage("rendering"):
            by_place = {each: (*taken, *aslant_pictures(true, first, each, scene, seeds)) for each in places}
    with stage("perception"):
        perceived = perceived_in(scene, contents, by_place, PrintSearch(sift, texture_seed))
    write_perceived(perceived, output, overwrite)
    if picture_path is not None:
        known = known_from(scene, first.viewpoint)
        write_png(perceived_picture(first.rgbd, known, perceived), picture_path, overwrite)
    if as_json:
        drawn = {} if picture_path is None else {"picture": str(picture_path)}
        emit_json({**perceived_values(perceived), "path": str(output), **drawn, "seed": seed})
        return
    for each in perceived.places:
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
