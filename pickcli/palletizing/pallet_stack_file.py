"""Writes stacks on pallets as JSON. See docs/formats/pallet.md."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pickcli.files.atomic_write import write_text
from pickcli.palletizing.drop_test import DropTest
from pickcli.palletizing.pallet_stack import PalletStack, Placement, loads_on

DECIMALS = 6  # of lengths, in m


def write_pallet_stack(path: Path, stack: PalletStack, tested: DropTest, replace: bool = True) -> None:
    """Write a stack with the result of its drop test.

    Args:
        path: The file.
        stack: The stack.
        tested: What became of it in the engine.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written, or exists.
    """
    write_text(path, json.dumps(stack_to_dict(stack, tested), indent=1) + "\n", replace)


def stack_to_dict(stack: PalletStack, tested: DropTest) -> dict[str, Any]:
    """Return the content of a file.

    Args:
        stack: The stack.
        tested: What became of it in the engine.

    Returns:
        Plain values.
    """
    pallet, loads = stack.order.pallet, loads_on(stack)
    return {
        "format": "apc stacked pallet",
        "version": 1,
        "pallet": {"size": list(pallet.size), "deck": pallet.deck, "height": pallet.height},
        "placements": [_placement(p, loads[p.carton.id]) for p in stack.placements],
        "left": [
            {"id": name, "reasons": [str(reason) for reason in reasons.reasons]}
            for name, reasons in stack.left.items()
        ],
        "drop_test": {
            "sinking_m": round(tested.sinking, DECIMALS),
            "shift_m": round(tested.shift, DECIMALS),
        },
    }


def _placement(placement: Placement, load: float) -> dict[str, Any]:
    return {
        "id": placement.carton.id,
        "size": list(placement.carton.size),
        "mass": placement.carton.mass,
        "position": _rounded(placement.centre),
        "yaw_deg": 90 if placement.is_turned else 0,
        "rests_on": list(placement.rests_on),
        "borne_within": [_rounded(corner) for corner in placement.bears_within],
        "load": round(load, 3),
        "comes_down_from": round(placement.from_above + float(placement.size[2]) / 2, DECIMALS),
    }


def _rounded(values: Any) -> list[float]:
    return [round(float(value), DECIMALS) for value in values]
