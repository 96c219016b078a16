"""Verification of a stack on a pallet, for ``apc verify``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pickcli.commands.command import emit_json
from pickcli.commands.logs import stage
from pickcli.errors import Reason, RejectedError

if TYPE_CHECKING:
    from pickcli.palletizing.drop_test import DropTest
    from pickcli.palletizing.stack_verification import StackVerdict


def verify_pallet(path: Path, order_path: Path | None, drops: bool, as_json: bool) -> None:
    """Verify a stack, and tell the verdict.

    Args:
        path: File of the stack.
        order_path: The order that it must be a stack of, if any.
        drops: Whether it is put up in the physics engine, too.
        as_json: Whether the verdict is told as JSON.

    Raises:
        InputError: A file cannot be read.
        RejectedError: The stack has faults.
    """
    from pickcli.palletizing.drop_test import drop_test
    from pickcli.palletizing.pallet_order_file import read_pallet_order
    from pickcli.palletizing.pallet_stack_file import read_pallet_stack
    from pickcli.palletizing.stack_verification import verify_stack

    order = None if order_path is None else read_pallet_order(order_path)
    stack = read_pallet_stack(path)
    with stage("verification"):
        verdict = verify_stack(stack, order)
    tested = None
    if drops:
        with stage("drop test"):
            tested = drop_test(stack.pallet, stack.placements)
    reasons = verdict.reasons + (() if tested is None else tested.reasons)
    if as_json:
        emit_json(_summary(path, verdict, tested, reasons))
    elif not reasons:
        click.echo(_text(len(stack.placements), verdict, tested))
    if reasons:
        raise RejectedError(str(path), reasons)


def _summary(
    path: Path, verdict: StackVerdict, tested: DropTest | None, reasons: tuple[Reason, ...]
) -> dict[str, Any]:
    def finite(value: float) -> float | None:
        return value if abs(value) < float("inf") else None

    return {
        "path": str(path),
        "accepted": not reasons,
        "clearance_m": finite(verdict.clearance),
        "margin_m": finite(verdict.margin),
        "load_share": verdict.load_share,
        "drop_test": None if tested is None else {"sinking_m": tested.sinking, "shift_m": tested.shift},
    }


def _text(n: int, verdict: StackVerdict, tested: DropTest | None) -> str:
    beside = f"at least {1e3 * verdict.clearance:.1f} mm beside others on the way down"
    rows = [
        ("accepted", f"{n} carton{'s' * (n != 1)}"),
        ("clearance", beside if verdict.clearance < float("inf") else "nothing is beside a way down"),
        ("balance", f"centres of mass at least {1e3 * verdict.margin:.1f} mm within what bears them"),
        ("load", f"at most {verdict.load_share:.0%} of what a carton bears"),
    ]
    if tested is not None:
        sinking, shift = 1e3 * tested.sinking, 1e3 * tested.shift
        rows.append(("drop test", f"nothing moved over {sinking:.1f} mm in height, {shift:.1f} mm sideways"))
    return "\n".join(f"{key:>14}: {value}" for key, value in rows)
