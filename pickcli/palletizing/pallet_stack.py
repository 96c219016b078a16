"""A stack on a pallet: where each carton stands, what bears it, and how it comes there."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from pickcli.errors import Failures
from pickcli.geometry import Array
from pickcli.palletizing.pallet_order import Carton, PalletOrder


@dataclass(frozen=True, eq=False)
class Placement:
    """One carton in its place. Positions are in the frame of the pallet, z from the deck.

    Attributes:
        carton: The carton.
        low: (3,) m, its lower corner.
        is_turned: Whether its length is along y.
        rests_on: Ids of the cartons that bear it; none on the deck.
        bears_within: (K, 2) m, polygon in which it is borne, and in which it bears others.
        from_above: m over the deck, of its lower side where the straight line down to its place begins.
    """

    carton: Carton
    low: Array
    is_turned: bool
    rests_on: tuple[str, ...]
    bears_within: Array
    from_above: float

    @property
    def size(self) -> Array:
        """(3,) m, along the axes of the pallet."""
        x, y, z = self.carton.size
        return np.array((y, x, z) if self.is_turned else (x, y, z))

    @cached_property
    def high(self) -> Array:
        """(3,) m, its upper corner."""
        return np.asarray(self.low + self.size)

    @property
    def centre(self) -> Array:
        """(3,) m, its middle."""
        return np.asarray(self.low + self.size / 2)


@dataclass(frozen=True, eq=False)
class PalletStack:
    """Cartons of an order on its pallet.

    Attributes:
        order: The order.
        placements: In the sequence in which they are put up.
        left: Reasons against each carton that has no place, by id.
    """

    order: PalletOrder
    placements: tuple[Placement, ...] = ()
    left: dict[str, Failures] = field(default_factory=dict)

    @property
    def share_placed(self) -> float:
        """Share of the cartons that have a place."""
        return len(self.placements) / len(self.order.cartons)

    @property
    def fill(self) -> float:
        """Share of the room under the highest carton that is filled."""
        if not self.placements:
            return 0.0
        volume = sum(float(np.prod(p.size)) for p in self.placements)
        top = max(float(p.high[2]) for p in self.placements)
        return volume / (top * float(np.prod(self.order.pallet.size)))


def all_bearing(placements: Iterable[Placement], names: Iterable[str]) -> frozenset[str]:
    """Find cartons and all that bear them, directly or through others.

    Args:
        placements: Of the stack.
        names: Ids of cartons in it.

    Returns:
        Ids.
    """
    bearers = {p.carton.id: p.rests_on for p in placements}
    found, todo = set(names), list(names)
    while todo:
        new = set(bearers[todo.pop()]) - found
        found |= new
        todo += new
    return frozenset(found)


def loads_on(stack: PalletStack) -> Counter[str]:
    """Sum what stands on each carton, wholly or in part, directly or through others.

    Args:
        stack: The stack.

    Returns:
        kg by id.
    """
    loads: Counter[str] = Counter()
    for placement in stack.placements:
        for name in all_bearing(stack.placements, placement.rests_on):
            loads[name] += placement.carton.mass  # type: ignore[assignment]
    return loads
