"""``apc make-stream``: random items that come along a conveyor."""

from __future__ import annotations

import math
from pathlib import Path

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.common_options import (
    CELL_HELP,
    json_option,
    output_option,
    refuse_output,
    seed_option,
)
from pickcli.commands.options.option_types import FiniteRange, NumberType

BELT_CELL = "conveyor_sia20"
MOST_ITEMS = 3_000  # as many as a file may have
MOST_GAP = 10.0  # m


def _stretch(ctx: click.Context, param: click.Parameter, text: str | None) -> tuple[float, float] | None:
    """Parse LO,HI in m; None if not stated. Raises BadParameter for anything else."""
    if text is None:
        return None
    try:
        low, high = (float(part) for part in text.split(","))
    except ValueError:
        low = high = math.nan
    if not (math.isfinite(low) and math.isfinite(high)):
        raise click.BadParameter(f"expected LO,HI in m, got {text!r}")
    return low, high


def _gap(ctx: click.Context, param: click.Parameter, text: str) -> tuple[float, float]:
    """Parse LO,HI in m. Raises BadParameter for anything else."""
    try:
        low, high = (float(part) for part in text.split(","))
    except ValueError:
        low = high = math.nan
    if not 0.0 <= low <= high <= MOST_GAP:
        raise click.BadParameter(f"expected LO,HI in m with 0 <= LO <= HI <= {MOST_GAP:g}, got {text!r}")
    return low, high


@click.command("make-stream", cls=Command)
@click.option("--items", "n_items", type=NumberType(1, MOST_ITEMS), default=100, show_default=True,
              metavar="N", help="Number of items.")  # fmt: skip
@click.option("--speed", type=FiniteRange(0.0, 5.0), metavar="V",
              help="m/s of the belt, 0 if it stands.  [default: the conveyor's nominal speed]")  # fmt: skip
@click.option("--gap", metavar="LO,HI", default="0.25,0.60", show_default=True, callback=_gap,
              help="Least and greatest distance in m from the end of an item to the next.")  # fmt: skip
@click.option("--one-by-one", is_flag=True,
              help="On a belt that stands: each item is set down when the one before is gone.")  # fmt: skip
@click.option("--within", metavar="LO,HI", callback=_stretch,
              help="m from the infeed, between which they are set down.  [default: the window]")  # fmt: skip
@click.option("--conveyor", metavar="NAME", help="Conveyor of the cell.  [default: its first]")
@click.option("--cell", "cell_name", metavar="NAME|FOLDER", default=BELT_CELL, show_default=True,
              help=CELL_HELP)  # fmt: skip
@output_option("stream")
@seed_option
@json_option
def command(
    n_items: int, speed: float | None, gap: tuple[float, float], one_by_one: bool,
    within: tuple[float, float] | None, conveyor: str | None, cell_name: str,
    output: Path, overwrite: bool, seed: int, as_json: bool,
) -> None:  # fmt: skip
    """Draw a random stream: items that come along a conveyor.

    They are drawn from those that the cup can hold by their top, or the fingers can pinch from above, and
    stand on one of their sides, turned at random, up to 0.13 m off the middle of the belt. The first one
    enters the belt at 0 s. On a belt that stands they lie within its window.

    \b
    Example:
      apc make-stream --items 10 --speed 0.33 --gap 0.25,0.60 --seed 4 -o stream.json
      apc inspect stream.json
    """
    from pickcli.cell.cell_file import load_workcell
    from pickcli.random_scenes.make_stream import StreamRequest, conveyors, make_stream
    from pickcli.scene.stream_file import write_stream

    if within is not None and not one_by_one:
        raise click.UsageError("--within: states where items are set down one by one; add --one-by-one")
    refuse_output(output, overwrite, cell_name)
    cell = load_workcell(cell_name).preferred
    belts = conveyors(cell)
    if speed is None:
        belt = belts.get(conveyor or next(iter(belts)), next(iter(belts.values()))).conveyor
        assert belt is not None
        speed = belt.nominal_speed
    with stage("drawing of the stream"):
        stream = make_stream(cell, StreamRequest(n_items, speed, gap, one_by_one, within), seed, conveyor)
    write_stream(stream, output, overwrite)
    if as_json:
        emit_json({
            "path": str(output), "cell": cell.name, "conveyor": stream.conveyor, "speed": speed,
            "items": [riding.id for riding in stream.items], "last_stamp": stream.items[-1].stamp,
            "seed": seed,
        })  # fmt: skip
    else:
        until = f", the last one enters at {stream.items[-1].stamp:.1f} s" if speed > 0.0 else ""
        s = "s" * (n_items != 1)
        click.echo(f"{n_items} item{s} on {stream.conveyor} at {speed:g} m/s{until}, seed {seed}: {output}")
