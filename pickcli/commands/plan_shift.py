"""``apc plan-shift``: one item moved within its place, planned, verified and written as a plan file."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command
from pickcli.commands.options.pick_request import plan_requested
from pickcli.commands.options.plan_options import PickOptions, pick_options
from pickcli.commands.options.scene_options import scene_options

if TYPE_CHECKING:
    from pickcli.planning.pick_problem import Shift


@click.command("plan-shift", cls=Command)
@scene_options
@click.option("--bin", "bin_name", metavar="PLACE", required=True, help="Bin or table with the item.")
@click.option("--item", metavar="ITEM", required=True,
              help="Item to move: its name, or its id in the scene (name#2).")  # fmt: skip
@click.option("--by", metavar="X,Y[,DEG]", required=True,
              help="mm into the place and to the left; degrees of a turn to the left.")  # fmt: skip
@pick_options
def command(bin_name: str, item: str, by: str, options: PickOptions) -> None:
    """Plan one shift: move an item within its bin, lifted a little.

    The cup lifts it, carries it aside, and puts it down again. That makes room for a grasp of another item,
    or of this one. The item must lie on the floor of a bin or table, and end there at rest. The plan is
    verified, and contains its certificate. Exit code 5 when there is no plan, with every reason; nothing is
    written then.

    \b
    Example:
      apc plan-shift --scene scene.json --bin bin_A --item kleenex_tissue_box --by 20,0 -o shift.json
    """
    from pickcli.errors import UnknownNameError
    from pickcli.planning.pick_problem import PickQuery

    shift = _parsed(by)
    scene = options.scene()
    scene.cell.require_places()
    if bin_name not in scene.cell.places:
        raise UnknownNameError("place", bin_name, list(scene.cell.places), "--bin")
    scene.find(item, bin_name)
    plan_requested(scene, (PickQuery(bin_name, item, bin_name, by=shift),), options)


def _parsed(text: str) -> Shift:
    """Return the shift that an option states. Raises UsageError if it is not two or three whole numbers."""
    import math

    from pickcli.planning.pick_problem import Shift

    try:
        numbers = [int(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (2, 3):
        raise click.UsageError(f"--by: expected X,Y or X,Y,DEG in whole mm and degrees, got {text!r}")
    x, y, turn = (*numbers, 0)[:3]
    return Shift(1e-3 * x, 1e-3 * y, math.radians(turn))
