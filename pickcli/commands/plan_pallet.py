"""``apc plan-pallet``: where each carton of an order stands on its pallet, in which sequence."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.common_options import json_option, output_option, refuse_output, seed_option
from pickcli.commands.options.option_types import PATH

if TYPE_CHECKING:
    from pickcli.palletizing.drop_test import DropTest
    from pickcli.palletizing.pallet_stack import PalletStack


@click.command("plan-pallet", cls=Command)
@click.argument("order_path", metavar="ORDER", type=PATH)
@click.option("--online", is_flag=True,
              help="Stack in the sequence of the order, as cartons come, not in one of its own.")  # fmt: skip
@click.option("--look-ahead", type=click.IntRange(0, 20), default=0, show_default=True, metavar="N",
              help="With --online: number of cartons after the present one that are seen.")  # fmt: skip
@click.option("--from", "side", type=click.Choice(["-x", "+x", "-y", "+y"]), metavar="SIDE",
              help="Put up level by level, the farthest first, from an arm beside -x, +x, -y or "
                   "+y.")  # fmt: skip
@output_option("stack")
@seed_option
@json_option
def command(
    order_path: Path,
    online: bool,
    look_ahead: int,
    side: str | None,
    output: Path,
    overwrite: bool,
    seed: int,
    as_json: bool,
) -> None:
    """Plan where each carton of an order stands on its pallet, and in which sequence.

    Every carton comes straight down and stands by itself at any time, by the polygons that bear it; then the
    whole is put up in the physics engine. What has no place, or moves there, is left, with the reasons. Exit
    code 5 when something is left; the stack of the others is written all the same.

    \b
    Example:
      apc plan-pallet pallet.json -o stack.json
      apc plan-pallet pallet.json --online --look-ahead 3 -o online.json
    """
    from pickcli.errors import NoPlanError
    from pickcli.palletizing.arm_sequence import seen_from
    from pickcli.palletizing.drop_test import what_stands
    from pickcli.palletizing.pallet_order_file import read_pallet_order
    from pickcli.palletizing.pallet_stack_file import StackedPallet, stack_to_dict, write_pallet_stack
    from pickcli.palletizing.stacking import stack_all, stack_as_they_come

    if look_ahead and not online:
        raise click.UsageError("--look-ahead is for --online; without it the whole order is known")
    if side and online:
        raise click.UsageError("--from is of a sequence of its own; with --online cartons come as they come")
    refuse_output(output, overwrite, order_path)
    order = read_pallet_order(order_path)
    with stage("stacking"):
        stack = stack_as_they_come(order, look_ahead) if online else stack_all(order, seed)
        stack = seen_from(stack, side) if side else stack
    with stage("drop test"):
        stack, tested = what_stands(stack)
    write_pallet_stack(output, stack, tested, overwrite)
    if as_json:
        written = stack_to_dict(StackedPallet.of(stack, tested))
        figures = {"placed": len(stack.placements), "of": len(order.cartons), "fill": stack.fill}
        emit_json({"path": str(output), **figures, **{key: written[key] for key in ("left", "drop_test")}})
    told = f"{_text(stack, tested)}: {output}"
    if stack.left:
        lines = [f"{len(stack.left)} of {len(order.cartons)} cartons are left"]
        lines += [f"  {reasons.summary()}" for reasons in stack.left.values()]
        reasons = [reason for left in stack.left.values() for reason in left.reasons]
        raise NoPlanError(f"all of {order_path}", reasons, "\n".join([*lines, f"written: {told}"]))
    if not as_json:
        click.echo(told)


def _text(stack: PalletStack, tested: DropTest) -> str:
    top = max((float(p.high[2]) for p in stack.placements), default=0.0) + stack.order.pallet.deck
    most = 1e3 * max(tested.sinking, tested.shift)
    return (
        f"{len(stack.placements)} of {len(stack.order.cartons)} cartons, {top:.2f} m high, "
        f"{100 * stack.fill:.0f} % full; nothing moved over {most:.0f} mm in the engine"
    )
