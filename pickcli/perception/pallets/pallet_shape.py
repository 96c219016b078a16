"""The shape of a pallet of three runners: boards, blocks, and the pockets between them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.cell.shapes import Body, box
from pickcli.geometry import Array


@dataclass(frozen=True)
class PalletShape:
    """A pallet, by default EUR 1 of UIC 435-2.

    Its frame is in the middle of its footprint on the floor, x out of the side into which the forks go, z up.
    Along x it has three runners of a bottom board and three blocks each; three boards across carry the deck.

    Attributes:
        name: Name in messages.
        length: m along x.
        width: m along y.
        board: m, thickness of the boards of bottom, deck, and those across.
        block_height: m.
        across: (3,) m, widths of the runners along y: at the right edge, in the middle, at the left edge.
        along: (3,) m, lengths of the blocks along x: at the back, in the middle, at the front.
        deck: m, widths of the boards of the deck along y, evenly apart.
    """

    name: str = "full"
    length: float = 1.2
    width: float = 0.8
    board: float = 0.022
    block_height: float = 0.078
    across: tuple[float, float, float] = (0.1, 0.145, 0.1)
    along: tuple[float, float, float] = (0.145, 0.145, 0.145)
    deck: tuple[float, ...] = (0.145, 0.1, 0.145, 0.1, 0.145)

    @property
    def opening(self) -> float:
        """M, height of the pockets, which begin on the floor."""
        return self.board + self.block_height

    @property
    def height(self) -> float:
        """M, of the deck's upper side."""
        return self.opening + 2 * self.board

    @cached_property
    def columns(self) -> Array:
        """(3, 2) m: least and largest y of the runners; what is between them are the pockets."""
        return _spread(self.across, self.width)

    @cached_property
    def pockets(self) -> Array:
        """(2, 2) m: least and largest y of the pockets."""
        return np.column_stack([self.columns[:-1, 1], self.columns[1:, 0]])

    @cached_property
    def bodies(self) -> tuple[Body, ...]:
        """Boards and blocks in the frame of the pallet."""
        half, low, high = self.length / 2, self.opening, self.opening + self.board
        rows = _spread(self.along, self.length)
        found = []
        for i, (right, left) in enumerate(self.columns):
            found.append(box(f"bottom {i}", (-half, right, 0.0), (half, left, self.board)))
            found += [
                box(f"block {i}{k}", (back, right, self.board), (front, left, low))
                for k, (back, front) in enumerate(rows)
            ]
        for k, (back, front) in enumerate(rows):
            found.append(box(f"across {k}", (back, -self.width / 2, low), (front, self.width / 2, high)))
        for i, (right, left) in enumerate(_spread(self.deck, self.width)):
            found.append(box(f"deck {i}", (-half, right, high), (half, left, self.height)))
        return tuple(found)


def _spread(widths: tuple[float, ...], whole: float) -> Array:
    """(N, 2) m: begins and ends of parts of such widths, evenly apart over a whole around 0."""
    gap = (whole - sum(widths)) / (len(widths) - 1)
    ends = np.cumsum(np.array(widths) + gap) - gap - whole / 2
    return np.column_stack([ends - widths, ends])


EUR_FULL = PalletShape()
# Of half pallets (EUR 6) there are several patterns; forks for full ones go into the side of 0.8 m.
EUR_HALF = PalletShape("half", length=0.6, along=(0.1, 0.1, 0.1))
PALLETS = {shape.name: shape for shape in (EUR_FULL, EUR_HALF)}
