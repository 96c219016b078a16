"""``apc make-order``: a random order by the official rules."""

from __future__ import annotations

from pathlib import Path

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.common_options import json_option, output_option, refuse_output, seed_option


@click.command("make-order", cls=Command)
@click.option("--task", type=click.Choice(["pick", "stow"], case_sensitive=False), default="pick",
              show_default=True,
              help="Move targets into the tote, or the tote's items into bins.")  # fmt: skip
@click.option("--year", type=click.Choice(["2015", "2016"]), default="2016", show_default=True,
              help="Year of the rules and items; 2015 had no stow task.")  # fmt: skip
@output_option("order")
@seed_option
@json_option
def command(task: str, year: str, output: Path, overwrite: bool, seed: int, as_json: bool) -> None:
    """Draw a random order by the official rules.

    It has the official format of its year: all items, as many per bin as the rules say, one target per bin.

    \b
    Example:
      apc make-order --task pick --year 2016 --seed 7 -o order.json
    """
    from pickcli.trial.make_order import make_order
    from pickcli.trial.order import OrderKind
    from pickcli.trial.output_file import write_output

    refuse_output(output, overwrite)
    with stage("drawing of the order"):
        order = make_order(OrderKind(task), int(year), seed)
    write_output(output, order, overwrite)
    if as_json:
        emit_json(
            {
                "path": str(output),
                "task": task,
                "year": order.year,
                "seed": seed,
                "items_per_bin": {name: len(names) for name, names in order.bin_contents.items()},
                "in_tote": len(order.tote_contents),
                "targets": len(order.work_order),
            }
        )
    else:
        n_items = sum(len(names) for names in order.bin_contents.values())
        n_targets = len(order.work_order) or len(order.tote_contents)
        targets = f"{n_targets} targets" if order.work_order else f"{n_targets} to stow"
        click.echo(f"{n_items} items in {len(order.bin_contents)} bins, {targets}, seed {seed}: {output}")
