"""``apc make-pallet-order``: a random order of cartons on a pallet."""

from __future__ import annotations

from pathlib import Path

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.options import json_option, output_option, refuse_output, seed_option


@click.command("make-pallet-order", cls=Command)
@click.option("--cartons", type=click.IntRange(1, 200), default=50, show_default=True, metavar="N",
              help="Number of cartons.")  # fmt: skip
@click.option("--container", default="eur_pallet", show_default=True, metavar="NAME",
              help="What they are stacked on: eur_pallet, half_pallet or roll_container.")  # fmt: skip
@output_option("order")
@seed_option
@json_option
def command(cartons: int, container: str, output: Path, overwrite: bool, seed: int, as_json: bool) -> None:
    """Draw a random order of cartons on a pallet.

    Sizes, masses and how many are alike are as in wholesale orders.

    \b
    Example:
      apc make-pallet-order --cartons 50 --seed 7 -o pallet.json
    """
    from pickcli.errors import UnknownNameError
    from pickcli.palletizing.pallet_order import CONTAINERS
    from pickcli.palletizing.pallet_order_file import write_pallet_order
    from pickcli.palletizing.random_pallet_order import random_pallet_order

    if container not in CONTAINERS:
        raise UnknownNameError("container", container, tuple(CONTAINERS), "--container")
    refuse_output(output, overwrite)
    order = random_pallet_order(cartons, seed, CONTAINERS[container])
    write_pallet_order(output, order, overwrite)
    volume = sum(c.size[0] * c.size[1] * c.size[2] for c in order.cartons)
    mass = sum(carton.mass for carton in order.cartons)
    if as_json:
        emit_json({"path": str(output), "cartons": cartons, "volume": volume, "mass": mass, "seed": seed})
    else:
        click.echo(
            f"{cartons} carton{'s' * (cartons > 1)}, {volume:.2f} m3, {mass:.0f} kg, seed {seed}: {output}"
        )
