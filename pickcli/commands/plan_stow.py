"""``apc plan-stow``: one item out of the tote into a bin, planned, verified and written as a plan file."""

from __future__ import annotations

import click

from pickcli.commands.command import Command
from pickcli.commands.options.pick_request import plan_requested
from pickcli.commands.options.plan_options import PickOptions, pick_options
from pickcli.commands.options.scene_options import scene_options
from pickcli.commands.options.stated_stow import bins_for, item_in_tote, stated_bin


@click.command("plan-stow", cls=Command)
@scene_options
@click.option("--item", metavar="ITEM", required=True,
              help="Item in the tote to stow: its name, or its id in the scene (name#2).")  # fmt: skip
@click.option("--into", metavar="PLACE",
              help="Destination: a bin.  [default: the one with most points of those that fit]")  # fmt: skip
@click.option("--neighbours", type=click.Choice(["avoid", "push"], case_sensitive=False), default="avoid",
              show_default=True,
              help="avoid other items in the tote, or push them aside on the way out of it.")  # fmt: skip
@pick_options
def command(item: str, into: str | None, neighbours: str, options: PickOptions) -> None:
    """Plan one stow: take an item out of the tote, and set it down in a bin.

    Without --into the bins are tried in the order of apc explain-stow, as if the scene were the start of the
    task. The plan is verified, and contains its certificate; if it is rejected, the next candidate is tried.
    Exit code 5 when there is no plan, with every reason; nothing is written then.

    \b
    Example:
      apc plan-stow --scene scene.json --item dove_beauty_bar --into bin_H -o plan.json
    """
    from pickcli.planning.pick_problem import PickQuery
    from pickcli.planning.pick_settings import Neighbours
    from pickcli.scene.scene import TOTE

    scene = options.scene()
    scene.cell.require_pod_and_tote()
    placed = item_in_tote(scene, item, "--item", "apc plan-pick")
    bins = bins_for(scene, placed) if into is None else (stated_bin(scene, placed, into, "--into"),)
    way = Neighbours(neighbours)
    queries = [PickQuery(TOTE, placed.id, name, neighbours=way) for name in bins]
    plan_requested(scene, queries, options, f"stow {placed.id}")
