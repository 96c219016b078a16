"""``apc make-scene``: items at rest in their places, by an order or as stated."""

from __future__ import annotations

from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.common_options import (
    cell_option,
    items_option,
    json_option,
    of_file,
    optional_order_argument,
    output_option,
    refuse_output,
    refuse_same,
    seed_option,
)
from pickcli.commands.options.option_types import PATH, FiniteRange, refuse_suffix
from pickcli.commands.options.pod_shift import pod_shift_option, tote_shift_option
from pickcli.commands.options.trial_options import pose_noise_option
from pickcli.commands.output.progress_bar import progress

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.cell.pod_tolerance import Displacement
    from pickcli.scene.scene import PoseNoise, Scene

Contents = dict[str, tuple[str, ...]]  # names of items by place

NEWEST = 2016  # year of items that no order names


@click.command("make-scene", cls=Command)
@optional_order_argument
@click.option(
    "--in", "stated", metavar="PLACE=ITEM[,ITEM]", multiple=True,
    help="Items in a place, besides those of the order; may be repeated.",
)  # fmt: skip
@click.option(
    "--leaning", "leaning_share", type=FiniteRange(0.0, 1.0), metavar="SHARE", default=0.0,
    help="Share of the items that lean on walls and each other, of those in bins that can.",
)  # fmt: skip
@output_option("scene")
@click.option("--picture", type=PATH, metavar="FILE.png", help="Also write a picture of the places.")
@click.option("--perceived", type=PATH, metavar="FILE.json",
              help="Also write the scene as perceived in a trial, with errors of the poses.")  # fmt: skip
@pose_noise_option
@tote_shift_option("none")
@pod_shift_option("none")
@cell_option
@items_option
@seed_option
@json_option
def command(
    order_path: Path | None,
    stated: tuple[str, ...],
    leaning_share: float,
    output: Path,
    overwrite: bool,
    picture: Path | None,
    perceived: Path | None,
    pose_noise: PoseNoise,
    pod_shift: Displacement | str | None,
    tote_shift: Displacement | str | None,
    cell_name: str,
    items_path: Path | None,
    seed: int,
    as_json: bool,
) -> None:
    """Place items in bins and other places, at rest.

    ORDER is a file, or the name of one under data/tasks. Items have their real sizes and masses. They are
    stowed in bins, heaped in boxes (for a stow order, in the tote), and laid side by side on tables. --in
    states the place of items, with or without an order.

    To carry out a plan for the scene of --perceived in the true one: apc execute --scene scene.json
    --planned-in seen.json.

    \b
    Example:
      apc make-scene jsk_pick_sample --seed 3 -o scene.json
      apc make-scene jsk_pick_sample --seed 3 -o true.json --perceived seen.json
      apc make-scene --in bin_C=dove_beauty_bar,crayola_24_ct --in tote=dasani_water_bottle -o filled.json
    """
    from pickcli.cell.cell_file import load_workcell
    from pickcli.cell.station import POD, TOTE
    from pickcli.scene.scene import CarrierPose
    from pickcli.scene.scene_file import scene_hash, write_scene
    from pickcli.simulation.reality import DEFAULT
    from pickcli.trial.order_file import order_file, read_order
    from pickcli.trial.pod_shift import NONE, pod_pose
    from pickcli.trial.tote_shift import tote_stands

    noise_is_from = click.get_current_context().get_parameter_source("pose_noise")
    if perceived is None and noise_is_from is ParameterSource.COMMANDLINE:
        raise click.UsageError("--pose-noise applies only to --perceived; add that, or leave it out")
    cell = load_workcell(cell_name, items_path).preferred  # a scene is of all arms
    cell.require_places()
    contents, year = _stated_contents(stated, cell), NEWEST
    order_source: Path | None = None
    if order_path is not None:
        order, order_source = read_order(order_path, cell), order_file(order_path, cell)
        contents, year = _together(order.contents, contents), order.year
    elif not contents:
        raise click.UsageError(
            "nothing to place: name an order, e.g. jsk_pick_sample, or items with --in PLACE=ITEM"
        )
    T_world_pod = pod_pose(pod_shift or NONE, cell, seed)
    tote, _ = tote_stands(tote_shift or NONE, DEFAULT, cell, seed)
    carriers = {POD: CarrierPose(T_world_pod)} | ({} if tote is None else {TOTE: tote})
    inputs = (order_source, cell_name, items_path)
    outputs = [path for path in (output, picture, perceived) if path is not None]
    for path in outputs:
        refuse_output(path, overwrite, *inputs)
    refuse_same(*outputs)
    if picture is not None:
        refuse_suffix(picture, (".png",), "a picture")

    from pickcli.random_scenes.leaning_items import leaning_items
    from pickcli.random_scenes.make_scene import make_scene, refuse_too_much

    where = "--in" if order_path is None else str(order_path)
    refuse_too_much(contents, cell, year, where)
    with stage("placing of the items"), progress("settling") as report, of_file(Path(where)):
        scene = make_scene(contents, cell, seed, year, report, carriers, leaning_share)
    write_scene(scene, output, overwrite)
    if perceived is not None:
        write_scene(_perceived(scene, pose_noise, seed), perceived, overwrite)
    if picture is not None:
        from pickcli.files.png_file import write_png
        from pickcli.simulation.camera import picture_of

        write_png(picture_of(scene), picture, overwrite)
    leaning = leaning_items(scene)
    names = {name: [placed.id for placed in scene.in_location(name)] for name in contents}
    if as_json:
        bins = {name: names.get(name, []) for name in (*cell.pod.bins, *names)}
        others = {"perceived": perceived, "picture": picture}
        emit_json({
            "path": str(output), "scene_hash": scene_hash(scene), "seed": seed, "bins": bins,
            "leaning": {name: round(degrees(angle), 2) for name, angle in leaning.items()},
            **{name: None if path is None else str(path) for name, path in others.items()},
        })  # fmt: skip
    else:
        n, m = len(scene.items), len(names)
        what = f"{'bin' if set(names) <= set(cell.pod.bins) else 'place'}{'s' * (m != 1)}"
        lean = f", {len(leaning)} of them leaning" if leaning_share else ""
        click.echo(f"{n} item{'s' * (n != 1)} at rest in {m} {what}{lean}, seed {seed}: {output}")
        if perceived is not None:
            click.echo(f"perceived scene: {perceived}")
        if picture is not None:
            click.echo(f"picture: {picture}")


def _perceived(scene: Scene, pose_noise: PoseNoise, seed: int) -> Scene:
    """Return the scene as perceived at the start of a trial."""
    from pickcli.simulation.reality import DEFAULT
    from pickcli.trial.pose_noise import perceive

    return perceive(scene, pose_noise, seed, 1, DEFAULT)


def _stated_contents(stated: tuple[str, ...], cell: Cell) -> Contents:
    """Parse --in: names of items by place. Raises UsageError for an invalid value."""
    from pickcli.errors import UnknownNameError

    contents: Contents = {}
    for text in stated:
        place, _, names = text.partition("=")
        items = tuple(name.strip() for name in names.split(","))
        if not all(items):
            example = f"{next(iter(cell.places), 'PLACE')}=dove_beauty_bar,crayola_24_ct, without spaces"
            raise click.UsageError(f"--in: expected PLACE=ITEM[,ITEM], got {text!r}; e.g. {example}")
        if place not in cell.places:
            raise UnknownNameError("place", place, list(cell.places), "--in")
        for name in items:
            cell.item(name)
        contents = _together(contents, {place: items})
    return contents


def _together(a: Contents, b: Contents) -> Contents:
    """Merge two mappings of items by place, the places of the first one first."""
    return {name: (*a.get(name, ()), *b.get(name, ())) for name in {**a, **b}}
