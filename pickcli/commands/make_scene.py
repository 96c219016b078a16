"""``apc make-scene``: an order's items at rest in their bins."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.option_types import PATH, refuse_suffix
from pickcli.commands.options import (
    cell_option,
    items_option,
    json_option,
    of_file,
    order_argument,
    output_option,
    refuse_output,
    refuse_same,
    seed_option,
)
from pickcli.commands.pod_shift import NONE, pod_pose, pod_shift_option
from pickcli.commands.progress_bar import progress

if TYPE_CHECKING:
    from pickcli.cell.pod_tolerance import Displacement


@click.command("make-scene", cls=Command)
@order_argument
@output_option("scene")
@click.option("--picture", type=PATH, metavar="FILE.png", help="Also write a picture of the pod's front.")
@pod_shift_option(NONE)
@cell_option
@items_option
@seed_option
@json_option
def command(
    order_path: Path,
    output: Path,
    overwrite: bool,
    picture: Path | None,
    pod_shift: Displacement | str | None,
    cell_name: str,
    items_path: Path | None,
    seed: int,
    as_json: bool,
) -> None:
    """Place the items of an order in their bins, at rest.

    ORDER is a file, or the name of one under data/tasks. Items have their real sizes and masses. What lies in
    the tote at the start of a stow order is not placed.

    \b
    Example:
      apc make-scene jsk_pick_sample --seed 3 -o scene.json
    """
    from pickcli.cell.cell_file import load_workcell
    from pickcli.scene.scene_file import scene_hash, write_scene
    from pickcli.trial.order_file import order_file, read_order

    cell = load_workcell(cell_name, items_path).preferred  # a scene is of all arms
    cell.require_places()
    order = read_order(order_path, cell)
    T_world_pod = pod_pose(pod_shift or NONE, cell, seed)
    inputs = (order_file(order_path), cell_name, items_path)
    refuse_output(output, overwrite, *inputs)
    if picture is not None:
        refuse_output(picture, overwrite, *inputs)
        refuse_same(output, picture)
        refuse_suffix(picture, (".png",), "a picture")

    from pickcli.stowing.make_scene import make_scene, refuse_too_much

    refuse_too_much(order.bin_contents, cell, order.year, str(order_path))
    with stage("stowing"), progress("settling") as report, of_file(order_path):
        scene = make_scene(order.bin_contents, cell, seed, order.year, report, T_world_pod)
    write_scene(scene, output, overwrite)
    if picture is not None:
        from pickcli.simulation.camera import picture_of, write_png

        write_png(picture_of(scene), picture, overwrite)
    if as_json:
        bins = {name: [placed.id for placed in scene.in_location(name)] for name in cell.pod.bins}
        emit_json({"path": str(output), "scene_hash": scene_hash(scene), "seed": seed, "bins": bins})
    else:
        click.echo(f"{len(scene.items)} items at rest in {len(cell.pod.bins)} bins, seed {seed}: {output}")
