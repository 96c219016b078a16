"""``apc explain-stow``: the bin assigned to each item of a stow order, with the reason, before any motion."""

from __future__ import annotations

from pathlib import Path

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.options.common_options import (
    cell_option,
    items_option,
    json_option,
    order_argument,
    stow_rule_option,
)
from pickcli.commands.output.table import stdout_console


@click.command("explain-stow", cls=Command)
@order_argument
@stow_rule_option
@cell_option
@items_option
@json_option
def command(order_path: Path, stow_rule: str, cell_name: str, items_path: Path | None, as_json: bool) -> None:
    """Show which bin is assigned to each item of a stow order, and why.

    ORDER is a file, or the name of one under data/tasks. The assignment depends only on the order, by the
    sizes of items and bins, not on how they lie: a trial tries the bins in this order, and stows an item
    into the first one that has a plan. --json lists them all.

    \b
    Example:
      apc explain-stow delft_stow_1
    """
    from rich.table import Table
    from rich.text import Text

    from pickcli.cell.cell_file import load_workcell
    from pickcli.errors import InputError
    from pickcli.trial.order import OrderKind
    from pickcli.trial.order_file import read_order
    from pickcli.trial.score import item_bonuses
    from pickcli.trial.stow_assignment import StowRule, assign_bins

    workcell = load_workcell(cell_name, items_path)
    cell = workcell.preferred
    order = read_order(order_path, cell)
    if order.kind is not OrderKind.STOW:
        is_no_order = order.kind is OrderKind.OUTPUT
        what = "nothing is in tote_contents" if is_no_order else f"this is a {order.kind} order"
        raise InputError(f"{order_path}: {what}; name a stow order, with items in tote_contents")
    tools = [each.robot.tool for each in workcell.arms.values()]
    choices = assign_bins(order, cell, item_bonuses(cell, order), tools, StowRule(stow_rule))
    total = sum(choice.points for choice in choices)
    if as_json:
        items = [
            {
                "item": c.item,
                "bins": list(c.bins) if c.can_be_held else [],
                "points": c.points,
                "reason": c.reason,
            }
            for c in choices
        ]
        emit_json({"rule": stow_rule, "points": total, "items": items})
        return
    console = stdout_console()
    table = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False)
    for title in ("item", "into"):
        table.add_column(title, overflow="fold")
    table.add_column("points", justify="right")
    table.add_column("because", overflow="fold")
    for choice in choices:
        into = choice.bins[0] if choice.bins and choice.can_be_held else "-"
        table.add_row(choice.item, into, str(choice.points), Text(choice.reason))
    with console.capture() as captured:
        console.print(table)
        console.print(f"{total} points if all are stowed there", highlight=False)
    click.echo("\n".join(line.rstrip() for line in captured.get().splitlines()))
