"""``apc believe``: the scene that looks leave a planner with."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.common_options import (
    cell_option,
    items_option,
    json_option,
    output_option,
    refuse_output,
)
from pickcli.commands.options.option_types import PATH, refuse_suffix
from pickcli.commands.output.perceived_lines import pod_lines
from pickcli.commands.output.table import table_lines

if TYPE_CHECKING:
    from pickcli.scene.scene import Scene


@click.command("believe", cls=Command)
@click.argument("paths", metavar="[PERCEIVED]...", type=PATH, nargs=-1)
@cell_option
@items_option
@click.option("--empty", "empty", metavar="PLACE", multiple=True,
              help="Place that is known to hold nothing; may be repeated.")  # fmt: skip
@click.option("--tote", "tote_path", type=PATH, metavar="FILE",
              help="Where the tote stands (see apc locate-tote).  [default: as the cell says]")  # fmt: skip
@output_option("scene")
@json_option
def command(
    paths: tuple[Path, ...], cell_name: str, items_path: Path | None, empty: tuple[str, ...],
    tote_path: Path | None, output: Path, overwrite: bool, as_json: bool,
) -> None:  # fmt: skip
    """Make the scene that a planner believes in from what was perceived.

    PERCEIVED are files of apc perceive and apc locate-pod, in order of time; none are needed with --tote.
    Answers become items, each with the bounds of its own error. Items that were refused are left out; what
    was seen of them, and all space that nobody has seen, is unknown: an obstacle. A place that no file is
    about is unknown as a whole, unless it is said to be empty. The pod is where it was last located, else
    where the last look into a bin has it.

    \b
    Example:
      apc believe perceived.json --empty tote -o believed.json
      apc believe pod.json perceived.json --empty tote -o believed.json
      apc believe perceived.json --tote tote.json --empty tote -o believed.json
    """
    from pickcli.calibration.tote_file import read_tote
    from pickcli.cell.cell_file import load_workcell
    from pickcli.perception.believed_scene import believed_scene
    from pickcli.perception.items.perceived_file import read_perceived
    from pickcli.scene.scene_file import write_scene

    if not paths and tote_path is None:
        raise click.UsageError("nothing to believe: name files of what was perceived, or --tote")
    refuse_output(output, overwrite, *paths, tote_path, cell_name, items_path)
    refuse_suffix(output, (".json",), "a scene")
    cell = load_workcell(cell_name, items_path).preferred  # a scene is of all arms
    cell.require_places()
    tote = None if tote_path is None else read_tote(tote_path, cell).carrier_pose(cell)
    with stage("reading of what was perceived"):
        looks = [read_perceived(path, cell) for path in paths]
    scene = believed_scene(cell, looks, empty, tote)
    write_scene(scene, output, overwrite)
    listed = {item.id for look in looks for place in look.places for item in place.items}
    left_out = sorted(listed - {placed.id for placed in scene.items})
    if as_json:
        spaces = {space.place: len(space.boxes) for space in scene.unknown}
        items = [placed.id for placed in scene.items]
        found = {"items": items, "left_out": left_out, "unknown_boxes": spaces}
        emit_json({**found, "pod_error": asdict(scene.pod_error), "path": str(output)})
        return
    for pod in [look.pod for look in looks if look.pod is not None][-1:]:
        for line in pod_lines(pod, cell):
            click.echo(line)
    _tell(scene, left_out)
    click.echo(f"scene: {output}")


def _tell(scene: Scene, left_out: list[str]) -> None:
    """Print a row for each place, and which listed items are not in the scene."""
    rows = []
    for space in scene.unknown:
        room = scene.cell.places[space.place].room
        volume = float((space.boxes[:, 1] - space.boxes[:, 0]).prod(axis=1).sum())
        share = f"{100.0 * min(1.0, volume / room.volume):.0f} %"
        rows.append([space.place, str(len(scene.in_location(space.place))), str(len(space.boxes)), share])
    for line in table_lines(["place", "items", "unknown boxes", "of its room"], rows):
        click.echo(line)
    if left_out:
        click.echo(f"left out, as they were refused or have no bounds: {', '.join(left_out)}")
