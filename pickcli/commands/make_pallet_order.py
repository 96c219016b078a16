"""``apc make-pallet-order``: a random order of cartons on a pallet."""

from __future__ import annotations

from pathlib import Path

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.options.common_options import json_option, output_option, refuse_output, seed_option
from pickcli.commands.options.option_types import FiniteRange


@click.command("make-pallet-order", cls=Command)
@click.option("--cartons", type=click.IntRange(1, 200), default=50, show_default=True, metavar="N",
              help="Number of cartons.")  # fmt: skip
@click.option("--container", default="eur_pallet", show_default=True, metavar="NAME",
              help="What they are stacked on: eur_pallet, half_pallet or roll_container.")  # fmt: skip
@click.option("--height", type=FiniteRange(0.3, 3.0), metavar="M",
              help="Over the floor, that nothing exceeds.  [default: that of the container]")  # fmt: skip
@click.option("--longest", type=FiniteRange(0.15, 1.0), default=0.6, show_default=True, metavar="M",
              help="Longest side of a carton's base.")  # fmt: skip
@click.option("--heaviest", type=FiniteRange(0.2, 100.0), default=25.0, show_default=True, metavar="KG",
              help="Mass of the heaviest cartons.")  # fmt: skip
@click.option("--clearance", type=FiniteRange(0.0, 0.1), default=0.005, show_default=True, metavar="M",
              help="Between cartons beside each other.")  # fmt: skip
@click.option("--edge", type=FiniteRange(0.0, 0.1), default=0.0, show_default=True, metavar="M",
              help="Between cartons and edges of the pallet without a wall.")  # fmt: skip
@click.option("--fall", type=FiniteRange(0.0, 0.02), default=0.0, show_default=True, metavar="M",
              help="That a carton may fall onto others as it is let go.")  # fmt: skip
@output_option("order")
@seed_option
@json_option
def command(
    cartons: int, container: str, height: float | None, longest: float, heaviest: float, clearance: float,
    edge: float, fall: float, output: Path, overwrite: bool, seed: int, as_json: bool,
) -> None:  # fmt: skip
    """Draw a random order of cartons on a pallet.

    Sizes, masses and how many are alike are as in wholesale orders, within the stated bounds.

    \b
    Example:
      apc make-pallet-order --cartons 50 --seed 7 -o pallet.json
      apc make-pallet-order --container half_pallet --cartons 10 --heaviest 10 --clearance 0.015 -o arm.json
    """
    from dataclasses import replace

    from pickcli.errors import UnknownNameError
    from pickcli.palletizing.pallet_order import CONTAINERS
    from pickcli.palletizing.pallet_order_file import write_pallet_order
    from pickcli.palletizing.random_pallet_order import CartonBounds, random_pallet_order

    if container not in CONTAINERS:
        raise UnknownNameError("container", container, tuple(CONTAINERS), "--container")
    refuse_output(output, overwrite)
    pallet = replace(CONTAINERS[container], edge=edge)
    pallet = pallet if height is None else replace(pallet, height=height)
    sizes = CartonBounds(longest=longest, heaviest=heaviest)
    order = replace(random_pallet_order(cartons, seed, pallet, sizes, clearance), fall=fall)
    write_pallet_order(output, order, overwrite)
    volume = sum(c.size[0] * c.size[1] * c.size[2] for c in order.cartons)
    mass = sum(carton.mass for carton in order.cartons)
    if as_json:
        emit_json({"path": str(output), "cartons": cartons, "volume": volume, "mass": mass, "seed": seed})
    else:
        click.echo(
            f"{cartons} carton{'s' * (cartons > 1)}, {volume:.2f} m3, {mass:.0f} kg, seed {seed}: {output}"
        )
