"""Writes the official task output file: the believed contents of all places after the task."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

from pickcli.files.atomic_write import write_text
from pickcli.scene.scene import TOTE, PlacedItem
from pickcli.trial.order import Order, OrderKind


def claim(order: Order, items: Iterable[PlacedItem]) -> Order:
    """Build the claimed state after the task from believed item locations.

    Items believed to be neither in a bin nor in the tote are left out.

    Args:
        order: The order that was played.
        items: Items at their believed locations.

    Returns:
        The state, of the kind OUTPUT.
    """
    placed = sorted(items, key=lambda i: i.id)
    by_bin = {b: tuple(i.item.name for i in placed if i.location == b) for b in order.bin_contents}
    tote = tuple(i.item.name for i in placed if i.location == TOTE)
    return Order(OrderKind.OUTPUT, order.year, by_bin, tote, ())


def order_text(order: Order) -> str:
    """Format an order as the official JSON of its year: one bin per line.

    Outputs have no ``work_order``, as the official sample output; orders of 2015 no ``tote_contents``.

    Args:
        order: The order.

    Returns:
        The text.
    """
    bins = ",\n".join(f"    {json.dumps(b)}: {json.dumps(names)}" for b, names in order.bin_contents.items())
    parts = [f'  "bin_contents": {{\n{bins}\n  }}']
    if order.year != 2015 or order.kind is OrderKind.OUTPUT:
        parts.append(f'  "tote_contents": {json.dumps(order.tote_contents)}')
    if order.kind is OrderKind.PICK:
        targets = [json.dumps({"bin": t.bin, "item": t.item}) for t in order.work_order]
        parts.append('  "work_order": [\n    ' + ",\n    ".join(targets) + "\n  ]")
    return "{\n" + ",\n".join(parts) + "\n}\n"


def write_output(path: Path, order: Order, replace: bool = True) -> None:
    """Write an order or output file.

    Args:
        path: The file.
        order: The order.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written.
    """
    write_text(path, order_text(order), replace)
