"""``apc show-grasps``: a page of one item, with its regions and candidate grasps."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.options.arm_options import ArmRequest, arm_option, open_cell
from pickcli.commands.options.common_options import (
    cell_option,
    items_option,
    json_option,
    output_option,
    refuse_output,
    seed_option,
)
from pickcli.commands.options.named_item import find_item, year_option
from pickcli.commands.options.option_types import refuse_suffix
from pickcli.errors import InputError, UnknownNameError

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.cell.place import Place


@click.command("show-grasps", cls=Command)
@click.argument("item_name", metavar="ITEM")
@year_option
@click.option("--place", "place_name", metavar="PLACE",
              help="Place that contains the item.  [default: the cell's first place]")  # fmt: skip
@cell_option
@items_option
@arm_option("the preferred one")
@output_option("page, an .html file")
@seed_option
@json_option
def command(
    item_name: str, year: int | None, place_name: str | None, cell_name: str, items_path: Path | None,
    arm: str | None, output: Path, overwrite: bool, seed: int, as_json: bool,
) -> None:  # fmt: skip
    """Make a page of an item with its regions and candidate grasps.

    It shows the regions for the centre of the cup, and an arrow for each candidate that a search samples for
    the item lying alone in a place, coloured by its share of what the tool bears. Obstacles are not
    considered; plan-pick does that.

    \b
    Example:
      apc show-grasps dasani_water_bottle -o bottle.html
    """
    from pickcli.files.atomic_write import write_bytes
    from pickcli.geometry import inverse, pose
    from pickcli.grasping.grasp_target import GraspTarget
    from pickcli.grasping.method_choice import grasp_method
    from pickcli.grasping.search import USUAL
    from pickcli.grasping.suction_candidates import HOLDS
    from pickcli.page.grasps_page import grasps_page
    from pickcli.page.html_page import page_bytes
    from pickcli.seeds import derived_rng

    refuse_suffix(output, (".html",), "a page")
    refuse_output(output, overwrite, cell_name, items_path)
    item = find_item(item_name, year, items_path)
    cell = open_cell(cell_name, ArmRequest(arm, items=items_path))
    cell.require_places()
    item = cell.items[item.name, item.year]  # as it seals under the cell's pump
    place = _place(cell, place_name)
    if sizes := place.room.too_small_for(item.shape.extents):
        raise InputError(f"--place: {item.name} does not fit into {place.name}: it has {sizes}")
    x, y, _ = (place.room.low + place.room.high) / 2
    z = float(place.room.floor_at(x)) + item.shape.extents[2] / 2
    target = GraspTarget(item.name, item, inverse(place.T_place_entry) @ pose((x, y, z)), place)
    rng = derived_rng("shown grasps", seed)
    found = grasp_method(cell.robot.tool).sample(target, rng, USUAL, HOLDS)
    content = page_bytes(grasps_page(item, cell.robot.tool, place.name, found))
    write_bytes(output, content, overwrite)
    if as_json:
        best = [{"kind": g.kind, "face": g.face, "load_ratio": g.load_ratio, "score": g.score,
                 "T_item_tip": g.T_item_tip.tolist()} for g in found.grasps]  # fmt: skip
        emit_json({"path": str(output), "item": item.name, "place": place.name, "bytes": len(content),
                   "grasps": best, "dropped": [str(reason) for reason in found.rejected]})  # fmt: skip
    else:
        click.echo(
            f"wrote {output}: {len(found.grasps)} candidates in {place.name}, {len(content) / 1e6:.2f} MB"
        )


def _place(cell: Cell, name: str | None) -> Place:
    if name is not None and name not in cell.places:
        raise UnknownNameError("place", name, list(cell.places), "--place")
    return cell.places[name or next(iter(cell.places))]
