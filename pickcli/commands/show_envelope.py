"""``apc show-envelope``: a page of the envelopes of an item, and of what a scene leaves of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.options.arm_options import ArmRequest, arm_option, open_cell
from pickcli.commands.options.common_options import (
    json_option,
    output_option,
    refuse_output,
    seed_option,
)
from pickcli.commands.options.named_item import find_item, year_option
from pickcli.commands.options.option_types import refuse_suffix
from pickcli.commands.options.scene_options import open_scene, scene_or_cell_options

if TYPE_CHECKING:
    from pickcli.grasping.envelope import Envelope
    from pickcli.page.envelope_page import EnvelopeRow
    from pickcli.scene.scene import PlacedItem, Scene

N_REACHED = 200  # poses of an envelope that the arm is tried at


@click.command("show-envelope", cls=Command)
@click.argument("item_name", metavar="ITEM")
@year_option
@scene_or_cell_options
@arm_option("the preferred one")
@output_option("page, an .html file")
@seed_option
@json_option
def command(
    item_name: str, year: int | None, scene_path: Path | None, cell_name: str | None, items_path: Path | None,
    arm: str | None, output: Path, overwrite: bool, seed: int, as_json: bool,
) -> None:  # fmt: skip
    """Make a page of the envelopes of an item: poses from which the tool can grasp it.

    In a scene, each is truncated to the largest part in which the tool without the arm is proven free at
    every pose, and the share of that part is estimated that the arm reaches.

    \b
    Example:
      apc show-envelope dasani_water_bottle --cell apc2016_delft -o bottle.html
      apc show-envelope kleenex_tissue_box --scene scene.json -o box.html
    """
    from pickcli.files.atomic_write import write_bytes
    from pickcli.page.envelope_page import envelope_page
    from pickcli.page.html_page import page_bytes

    refuse_suffix(output, (".html",), "a page")
    refuse_output(output, overwrite, scene_path, cell_name, items_path)
    request = ArmRequest(arm, items=items_path)
    scene, target = _found(item_name, year, scene_path, cell_name, request)
    rows = _rows(scene, target, seed, is_in_scene=scene_path is not None)
    others = [each for each in scene.items if each.id != target.id]
    content = page_bytes(envelope_page(target, others, rows))
    write_bytes(output, content, overwrite)
    if as_json:
        told = {"path": str(output), "item": target.id, "bytes": len(content)}
        emit_json(told | {"envelopes": [_as_json(row) for row in rows]})
        return
    for row in rows:
        click.echo(_as_text(row))
    click.echo(f"wrote {output}: {len(rows)} envelope{'s' * (len(rows) != 1)}, {len(content) / 1e6:.2f} MB")


def _found(
    name: str, year: int | None, scene_path: Path | None, cell_name: str | None, request: ArmRequest
) -> tuple[Scene, PlacedItem]:
    """Return the item in its scene; without one, by itself in the first place of a cell."""
    from pickcli.geometry import pose
    from pickcli.scene.scene import PlacedItem, empty_scene

    if scene_path is not None:
        if year is not None:
            raise click.UsageError("--year is for items without a scene; leave it out with --scene")
        scene = open_scene(scene_path, cell_name, request)
        return scene, scene.find(name)
    if cell_name is None:
        raise click.UsageError("no surroundings: name a scene with --scene, or a cell with --cell")
    item = find_item(name, year, request.items)
    cell = open_cell(cell_name, request)
    cell.require_places()
    item = cell.items[item.name, item.year]  # as it seals under the cell's pump
    place = next(iter(cell.places.values()))
    T = cell.T_world_place(place) @ pose((place.room.low + place.room.high) / 2)
    target = PlacedItem(item.name, item, place.name, T)
    return replace(empty_scene(cell), items=(target,)), target


def _rows(scene: Scene, target: PlacedItem, seed: int, is_in_scene: bool) -> list[EnvelopeRow]:
    from pickcli.grasping.envelope_truncation import truncated
    from pickcli.page.envelope_page import EnvelopeRow
    from pickcli.planning.item_envelopes import ItemEnvelopes
    from pickcli.planning.planning_context import PlanningContext
    from pickcli.seeds import derived_rng

    context, tool = PlanningContext(scene.cell), scene.cell.robot.tool
    states = [tool.default_state] if tool.grip.takes_widths else list(tool.states)
    in_states = [ItemEnvelopes.of(context, scene, target, state) for state in states]
    if not is_in_scene:
        return [EnvelopeRow(envelope, str(states[0])) for envelope in in_states[0].envelopes]
    rows = []
    for k, envelope in enumerate(in_states[0].envelopes):
        left = [truncated(found.envelopes[k], target.T_world_item, found.tool) for found in in_states]
        best = max(range(len(states)), key=lambda i: left[i].size)
        rng, part, reached = derived_rng("reached", envelope.name, seed), left[best].envelope, 0.0
        if part is not None:
            reached = in_states[best].reached(context, part, N_REACHED, rng)
        rows.append(EnvelopeRow(envelope, str(states[best]), left[best], reached))
    return rows


def _as_json(row: EnvelopeRow) -> dict[str, object]:
    envelope, left = row.envelope, row.truncation
    told: dict[str, object] = {
        "name": envelope.name, "tool_state": row.tool_state, "about": envelope.surface.name.lower(),
        "low": envelope.low.tolist(), "high": envelope.high.tolist(), "cone": float(envelope.cone),
        "depth": envelope.depth, "T_object_surface": envelope.T_object_surface.tolist(),
        "alignment": _alignment(envelope),
    }  # fmt: skip
    if left is not None:
        part = left.envelope
        told |= {
            "kept": left.kept, "cone_share": left.cone_share, "roll_share": left.roll_share,
            "reached": row.reached,
            "kept_low": None if part is None else part.low.tolist(),
            "kept_high": None if part is None else part.high.tolist(),
            "kept_cone": None if part is None else float(part.cone),
            "kept_alignment": None if part is None else _alignment(part),
            "against": None if left.against is None else str(left.against),
        }  # fmt: skip
    return told


def _alignment(envelope: Envelope) -> dict[str, object] | None:
    if (aligned := envelope.alignment) is None:
        return None
    axes = {"tool_axis": aligned.tool_axis.tolist(), "object_axis": aligned.object_axis.tolist()}
    return {**axes, "angle": float(aligned.angle)}


def _as_text(row: EnvelopeRow) -> str:
    left = row.truncation
    if left is None:
        return f"{row.envelope.name}"
    why = "" if left.against is None else f"; in the way: {left.against}"
    if left.envelope is None:
        return f"{row.envelope.name}: nothing is proven free{why}"
    roll = "" if left.roll_share == 1.0 else f" and {left.roll_share:.0%} of its roll"
    kept = f"{left.kept:.0%} of it with {left.cone_share:.0%} of its cones{roll} is proven free"
    return (
        f"{row.envelope.name}, tool {row.tool_state}: {kept}, of which the arm reaches {row.reached:.0%}{why}"
    )
