"""The sequence in which an arm puts up a stack from one side: level by level, the farthest carton first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pickcli.palletizing.pallet_order import ROUNDED
from pickcli.palletizing.pallet_stack import PalletStack, Placement
from pickcli.palletizing.stacking import ABOVE


def seen_from(stack: PalletStack, side: str) -> PalletStack:
    """Return a stack in the sequence in which an arm beside the pallet puts it up.

    Of the cartons that may come next, the one comes whose upper side is lowest, and of these the one that is
    farthest from the arm: so the arm seldom reaches down behind what is higher. One may come if all have come
    that came before it and are, seen from above, below it or nearer than the clearance.

    Args:
        stack: The stack.
        side: Of ``SIDES``, the one beside which the arm stands.

    Returns:
        The same placements in another sequence.
    """
    axis, sign = "xy".index(side[1]), -1.0 if side[0] == "-" else 1.0
    waiting, there = list(stack.placements), list[Placement]()
    while waiting:
        free = [p for k, p in enumerate(waiting) if not _is_over_any(p, waiting[:k], stack.order.clearance)]
        first = min(free, key=lambda p: (round(float(p.high[2]), 6), sign * float(p.centre[axis])))
        top = max((float(p.high[2]) for p in there), default=0.0)
        waiting = [p for p in waiting if p is not first]
        there.append(replace(first, from_above=top + ABOVE))
    return replace(stack, placements=tuple(there))


def _is_over_any(placement: Placement, earlier: Sequence[Placement], clearance: float) -> bool:
    """Whether a carton is over others that came before it, or beside them and higher."""
    for other in earlier:
        gap = np.maximum(other.low - placement.high, placement.low - other.high)[:2].max()
        if gap < clearance - ROUNDED and placement.low[2] >= other.high[2] - ROUNDED:
            return True
    return False
