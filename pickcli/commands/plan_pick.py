"""``apc plan-pick``: one pick, planned, verified and written as a plan file."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command
from pickcli.commands.options.option_types import RenamedOption
from pickcli.commands.options.pick_request import plan_requested
from pickcli.commands.options.plan_options import RecordedPickOptions, recorded_pick_options
from pickcli.commands.options.scene_options import scene_or_cell_options
from pickcli.commands.options.stated_pick import destination, refuse_impossible
from pickcli.commands.options.stream_options import StreamOptions, plan_from_stream, stream_options
from pickcli.commands.options.stream_plan_options import refuse_stream_rule, stream_rule_option
from pickcli.errors import InputError

if TYPE_CHECKING:
    from pickcli.planning.pick_problem import StatedPlace
    from pickcli.scene.scene import Scene

MINUTE_PLACE = 5.0  # mm of each coordinate, below which metres were probably meant


@click.command("plan-pick", cls=Command)
@scene_or_cell_options
@stream_options
@click.option("--bin", "bin_name", metavar="PLACE", help="Bin or other place that contains the item.")
@click.option("--item", metavar="ITEM", help="Item to pick: its name, or its id in the scene (name#2).")
@click.option("--pick", metavar="PLACE:ITEM", hidden=True)  # former spelling of --bin PLACE --item ITEM
@click.option("--into", cls=RenamedOption, old=("--to",), metavar="PLACE",
              help="Destination: another place of the cell.  [default: tote]")  # fmt: skip
@click.option("--at", metavar="X,Y,Z[,DEG]",
              help="Where the item is to stand in a destination that is no open box: mm of its middle in the "
                   "place's frame, and degrees to the left.")  # fmt: skip
@click.option("--neighbours", type=click.Choice(["avoid", "push", "ignore"], case_sensitive=False),
              default="avoid", show_default=True,
              help="avoid other items in the place (Delft), push them aside on the way out of an open "
                   "box, or ignore them (KTH).")  # fmt: skip
@stream_rule_option
@recorded_pick_options
def command(
    bin_name: str | None, item: str | None, pick: str | None, into: str | None, at: str | None,
    neighbours: str, request: StreamOptions, stream_rule: str, options: RecordedPickOptions,
) -> None:  # fmt: skip
    """Plan one pick: take an item, and bring it to the tote or to another place.

    Over boxes that are open above, the item is released just above their content; on shelves and tables it is
    set down. The plan is verified, and contains its certificate; if it is rejected, the next candidate is
    tried. Exit code 5 when there is no plan, with every reason; nothing is written then.

    From a running conveyor, name a stream and its time instead of a scene: the item is met at the earliest
    time at which the arm can be there, or the reasons say why never. By --stream-rule pr2-2013 it is met at
    one place, by the first arm that has a plan; with --planner ara-star the transit to the pregrasp is
    planned as the PR2 did it.

    \b
    Example:
      apc plan-pick --scene scene.json --bin bin_A --item kleenex_tissue_box -o plan.json
      apc plan-pick --scene scene.json --bin bin_A --item kleenex_tissue_box --into bin_F -o aside.json
      apc plan-pick --stream stream.json --item crayola_24_ct --now 1.5 -o belt.json
      apc plan-pick --stream stream.json --item crayola_24_ct --planner ara-star --expansions 500 -o belt.json
    """
    from pickcli.planning.pick_problem import PickQuery
    from pickcli.planning.pick_settings import Neighbours

    request.refuse_scene(options.scene_path)
    options.refuse_contradictions()
    if request.stream_path is not None:
        is_of_scene = bin_name is not None or pick is not None or at is not None
        if is_of_scene or neighbours != Neighbours.AVOID:
            raise click.UsageError("--bin, --at and --neighbours are for scenes; leave them out")
        plan_from_stream(request, item, into, stream_rule, options)
        return
    refuse_stream_rule()
    if options.scene_path is None:
        raise click.UsageError("name a scene with --scene, or items on a conveyor with --stream")
    scene = options.scene()
    scene.cell.require_places()
    out_of, item = _taken(pick, bin_name, item, scene)
    into = destination(scene, into, out_of)
    stated = None if at is None else _stated(at)
    query = PickQuery(out_of, item, into=into, neighbours=Neighbours(neighbours), at=stated)
    out_of_option = "--bin" if pick is None else "--pick"
    refuse_impossible(scene, query, out_of_option=out_of_option, into_option="--into")
    if stated is not None and scene.cell.places[into].is_open_box:
        raise InputError(f"--at: into {into} items are dropped, wherever there is room; leave it out")
    plan_requested(scene, (query,), options)


def _stated(text: str) -> StatedPlace:
    """Return the place that an option states. Raises UsageError if it is not three or four numbers."""
    import math

    from pickcli.planning.pick_problem import StatedPlace

    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (3, 4) or not all(map(math.isfinite, numbers)):
        raise click.UsageError(f"--at: expected X,Y,Z or X,Y,Z,DEG in mm and degrees, got {text!r}")
    x, y, z, turn = (*numbers, 0.0)[:4]
    if any(numbers[:3]) and max(abs(x), abs(y), abs(z)) < MINUTE_PLACE:
        click.echo(
            f"note: --at {text}: within {MINUTE_PLACE:g} mm of the place's origin; it is in mm", err=True
        )
    return StatedPlace(1e-3 * x, 1e-3 * y, 1e-3 * z, math.radians(turn))


def _taken(pick: str | None, place: str | None, item: str | None, scene: Scene) -> tuple[str, str]:
    """Return the place to pick from, and the item's name or id. Raises UsageError unless stated once."""
    if pick is None and place is not None and item is not None:
        return place, item
    if pick is None or place is not None or item is not None:
        raise click.UsageError("name the item once, with --bin PLACE --item ITEM")
    place, _, item = pick.partition(":")
    advice = "" if place and item else "--bin PLACE --item ITEM"
    if ":" in item and item not in {placed.id for placed in scene.items}:
        item, _, into = item.partition(":")
        advice = f"--bin {place} --item {item} --into {into or 'PLACE'}"
    if advice:
        raise click.UsageError(f"--pick: expected PLACE:ITEM, got {pick!r}; write {advice}")
    return place, item
