"""``apc perceive``: poses of the items of bins from one look of a camera of the cell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import click

from pickcli.commands.arm_options import ArmRequest, arm_option, standing_option
from pickcli.commands.camera_pictures import (
    CameraPicture,
    aslant_pictures,
    recorded_pictures,
    refuse_half,
    simulated_picture,
)
from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.named_camera import camera_or_recording_options, deformed_option, sift_option
from pickcli.commands.option_types import PATH, refuse_suffix
from pickcli.commands.options import (
    json_option,
    output_option,
    refuse_output,
    refuse_reading,
    refuse_same,
    seed_option,
)
from pickcli.commands.perceived_lines import perceived_lines
from pickcli.commands.scene_options import scene_or_cell_options, scene_or_empty

if TYPE_CHECKING:
    from pickcli.cell.place import Place
    from pickcli.perception.items.item_observation import PlaceObservation
    from pickcli.perception.items.listed_item import ListedItem
    from pickcli.perception.items.room_sight import RoomSight
    from pickcli.perception.items.routing import PrintSearch
    from pickcli.perception.textures.sift_views import SiftRule
    from pickcli.scene.scene import Scene

_Contents: TypeAlias = "Mapping[str, Sequence[ListedItem]]"


@click.command("perceive", cls=Command)
@scene_or_cell_options
@click.option("--order", "order_path", type=PATH, metavar="ORDER",
              help="Order that says what is in each place.  [default: what the scene has there]")  # fmt: skip
@camera_or_recording_options
@click.option("--aslant", "is_aslant", is_flag=True,
              help="Let the camera look into each place from both sides, too, by 20 "
                   "degrees.")  # fmt: skip
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
              metavar="N", help="Which set of prints the items have; models know set 0, but with --sift this "
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
    confidence, and is refused with a reason where that is too low. With --sift a pose found by its print has
    the right side in front, where shapes alone leave open which of several like sides that is.

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
    from pickcli.errors import InputError
    from pickcli.files.png_file import write_png
    from pickcli.perception.items.perceived_file import Perceived, perceived_values, write_perceived
    from pickcli.perception.items.routing import PrintSearch
    from pickcli.perception.perceived_picture import perceived_picture

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
    prints = PrintSearch(sift, texture_seed)
    configurations = () if recorded else (at or "home",)
    arms = ArmRequest(arm, standing, configurations, items=items_path, camera=name)
    scene = scene_or_empty(scene_path, cell_name, arms)
    contents = _contents(scene, order_path, is_deformed)
    if recorded:
        taken = recorded_pictures(scene, recorded)
        for path in filter(None, (output, picture_path)):
            refuse_reading(path, *(file for each in taken for file in each.files))
    else:
        assert name is not None
        taken = (simulated_picture(scene, name, at or "home", (texture_seed, seed), is_deformed),)
    true = scene
    if pod_path is not None:
        scene = _with_pod(scene, pod_path)
    places = _places(scene, bin_names, contents, taken)
    first = taken[0]
    if is_aslant and first.camera.link is None:
        raise InputError(f"camera {first.camera.name}: no arm moves it, so it does not look aslant")
    by_place = {
        place: (*taken, *aslant_pictures(true, first, place, scene, (texture_seed, seed), is_deformed))
        if is_aslant
        else taken
        for place in places
    }
    with stage("perception"):
        found = tuple(_perceived(scene, contents, place, by_place[place], prints) for place in places)
    used = {id(each): each for pictures in by_place.values() for each in pictures if each is not first}
    others = tuple(each.rgbd.T_world_camera for each in used.values())
    perceived = Perceived(
        scene.cell.name, first.camera.name, first.camera.model.name, first.rgbd.T_world_camera, found,
        also_from=others,
    )  # fmt: skip
    write_perceived(perceived, output, overwrite)
    if picture_path is not None:
        known = first.known(scene)
        write_png(perceived_picture(first.rgbd, known, perceived), picture_path, overwrite)
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


def _contents(scene: Scene, order_path: Path | None, may_deform: bool) -> _Contents:
    """What is listed to be in each place: by an order, or else as the scene has it; perhaps it deforms."""
    from pickcli.perception.items.listed_item import ListedItem
    from pickcli.random_scenes.make_scene import instances_of
    from pickcli.trial.order_file import read_order

    if order_path is None:
        held = None if scene.held is None else scene.held.id
        return {
            name: [
                ListedItem.of(each.id, each.item, may_deform)
                for each in scene.in_location(name)
                if each.id != held
            ]
            for name in scene.cell.places
        }
    order = read_order(order_path, scene.cell)
    listed = instances_of(order.contents, scene.cell, order.year)
    return {
        name: [ListedItem.of(each.id, each.item, may_deform) for each in items]
        for name, items in listed.items()
    }


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


def _places(
    scene: Scene, names: tuple[str, ...], contents: _Contents, taken: Sequence[CameraPicture]
) -> list[Place]:
    """The named places, or those of which a picture shows enough."""
    from pickcli.errors import InputError, UnknownNameError
    from pickcli.perception.items.room_sight import LEAST_SEEN

    cell = scene.cell
    for name in names:
        if name not in cell.places:
            raise UnknownNameError("place", name, list(cell.places), "--bin")
    if names:
        return [cell.places[name] for name in dict.fromkeys(names)]
    listed = [place for place in cell.places.values() if contents.get(place.name)]
    if not listed:
        raise InputError("no items are listed to be in any place; name a place to look into with --bin")
    sights = {place: _best_sight(scene, place, taken) for place in listed}
    most = max(sights, key=lambda place: sights[place].seen)
    if not sights[most].is_enough:
        best = f"of {most.name}, the best of these, {sights[most].fault}" if sights[most].seen else ""
        how = "take it" if len(taken) > 1 or taken[0].is_recorded else "move the arm with --at"
        raise InputError(
            f"{taken[0].where}: shows less than {LEAST_SEEN:.0%} of the room of every place with items"
            f"{': ' * bool(best)}{best}; {how} before one"
        )
    return [place for place, sight in sights.items() if sight.is_enough]


def _best_sight(scene: Scene, place: Place, taken: Sequence[CameraPicture]) -> RoomSight:
    return max((each.sight_of(scene, place) for each in taken), key=lambda sight: sight.seen)


def _perceived(
    scene: Scene,
    contents: _Contents,
    place: Place,
    taken: Sequence[CameraPicture],
    prints: PrintSearch,
) -> PlaceObservation:
    """The answers for a place, by all pictures that show enough of it; by the best one if none does."""
    from pickcli.perception.items.item_perception import PlaceLook, concluded

    T, listed = scene.T_world_place(place), contents.get(place.name, ())
    sights = [(each, each.sight_of(scene, place)) for each in taken]
    enough = [each for each, sight in sights if sight.is_enough]
    used = enough or [max(sights, key=lambda seen: seen[1].seen)[0]]
    found = concluded([PlaceLook.of(each.rgbd, place, T, listed, each.known(scene), prints) for each in used])
    return replace(found, error=scene.pose_of(scene.cell.carriers[place.carrier]).error)
