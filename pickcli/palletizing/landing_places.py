"""Places where a carton can come down on a stack, straight from above.

Candidates are where an edge of it is in line with, or beside, an edge of another or of the pallet: pushed
together, any stack becomes one of these (E. Bischoff, M. Marriott, EJOR 44, 1990, use the same corners). They
form a grid, on which what is below or beside each carton of the stack is a rectangle of rows and columns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.geometry import Array
from pickcli.palletizing.pallet_order import LEVEL, ROUNDED, Carton, PalletOrder, least_contact
from pickcli.palletizing.pallet_stack import Placement

MOST_EDGES = 160  # positions along one axis, evenly chosen of more


@dataclass(frozen=True, eq=False)
class PlacementArrays:
    """What stands on a pallet, as arrays.

    Attributes:
        low: (K, 3) m, lower corners.
        high: (K, 3) m, upper corners.
        borne_low: (K, 2) m, lower corner of the rectangle around the polygon in which each bears others.
        borne_high: (K, 2) m, its upper corner.
        spare: (K,) kg that may still stand on each, by its own limit and those of all that bear it.
    """

    low: Array
    high: Array
    borne_low: Array
    borne_high: Array
    spare: Array

    @classmethod
    def of(cls, placements: Sequence[Placement], spare: Sequence[float]) -> PlacementArrays:
        """Build the arrays.

        Args:
            placements: What stands on the pallet.
            spare: kg that may still stand on each.

        Returns:
            The arrays.
        """
        polygons = [p.bears_within for p in placements]
        return cls(
            np.array([p.low for p in placements]).reshape(-1, 3),
            np.array([p.high for p in placements]).reshape(-1, 3),
            np.array([polygon.min(axis=0) for polygon in polygons]).reshape(-1, 2),
            np.array([polygon.max(axis=0) for polygon in polygons]).reshape(-1, 2),
            np.array(spare),
        )


@dataclass(frozen=True, eq=False)
class LandingPlaces:
    """Places of one carton in one orientation.

    Attributes:
        low: (N, 3) m, lower corner of the carton in each.
        is_turned: Whether its length is along y.
        supported_share: (N,) share of its base that is supported.
        beside: (N,) m of the sides of its base that are beside others, or at the edge of the pallet.
        spare: (N,) kg that may still stand on what bears it.
        borne_low: (N, 2) m, lower corner of a rectangle around all that can be in its support polygon.
        borne_high: (N, 2) m, its upper corner; lower than that where nothing bears it.
    """

    low: Array
    is_turned: bool
    supported_share: Array
    beside: Array
    spare: Array
    borne_low: Array
    borne_high: Array


def landing_places(order: PalletOrder, placed: PlacementArrays, carton: Carton) -> list[LandingPlaces]:
    """Find where a carton can come down, whether or not it stands there.

    Args:
        order: The order.
        placed: What is on the pallet.
        carton: The carton.

    Returns:
        For each orientation in which it fits on the pallet.
    """
    room = np.array(order.pallet.room(order.clearance))
    found = []
    for is_turned in (False,) if carton.size[0] == carton.size[1] else (False, True):
        size = np.array(carton.size)[[1, 0, 2]] if is_turned else np.array(carton.size)
        if (size[:2] <= room[1] - room[0] + ROUNDED).all():
            found.append(_Grid(order, placed, size, room).places(is_turned))
    return found


class _Grid:
    """All positions of a carton's base: X along the pallet, Y across it.

    order: what is stacked. placed: what stands there. size: (3,) m of the carton as it is turned.
    room: (2, 2) m, lower and upper corner of the part of the deck that may be used
    """

    def __init__(self, order: PalletOrder, placed: PlacementArrays, size: Array, room: Array) -> None:
        self._order, self._placed, self._size, self._room = order, placed, size, room
        self._at = [self._along(k) for k in (0, 1)]
        # (X, K) and (Y, K) m that base and carton share along each axis, negative where they are apart
        self._shared = [
            np.minimum(at[:, None] + size[k], placed.high[:, k]) - np.maximum(at[:, None], placed.low[:, k])
            for k, at in enumerate(self._at)
        ]
        self._over = self._blocks(ROUNDED)

    def _along(self, k: int) -> Array:
        """Return positions of the lower side along one axis: in line with edges, and beside them."""
        low, high, keeps = self._placed.low[:, k], self._placed.high[:, k], self._order.clearance
        starts = np.concatenate([self._room[:1, k], low, high + keeps])
        ends = np.concatenate([self._room[1:, k], high, low - keeps]) - self._size[k]
        found = np.concatenate([starts, ends])
        is_inside = (found >= self._room[0, k] - ROUNDED) & (
            found + self._size[k] <= self._room[1, k] + ROUNDED
        )
        found = np.unique(np.round(found[is_inside], 6))
        if len(found) > MOST_EDGES:
            found = found[np.linspace(0, len(found) - 1, MOST_EDGES).round().astype(int)]
        return np.asarray(found)

    def _blocks(self, least: float) -> list[tuple[int, slice, slice]]:
        """Return, for each carton whose bases share more than a length along both axes, where they do."""
        first, last = [], []
        for shared in self._shared:
            is_so = shared > least
            first.append(is_so.argmax(axis=0))
            last.append(first[-1] + is_so.sum(axis=0))  # the positions are sorted, so these are without gaps
        rows = np.array([*first, *last]).T.tolist()
        return [(k, slice(x, X), slice(y, Y)) for k, (x, y, X, Y) in enumerate(rows) if x < X and y < Y]

    def places(self, is_turned: bool) -> LandingPlaces:
        """Return the positions where the carton can come down."""
        n_x, n_y = map(len, self._at)
        z, highest = np.zeros((n_x, n_y)), np.zeros((n_x, n_y))
        tops = self._placed.high[:, 2].tolist()
        for block, blocks in ((z, self._over), (highest, self._blocks(ROUNDED - self._order.clearance))):
            for k, rows, columns in blocks:
                np.maximum(block[rows, columns], tops[k], out=block[rows, columns])
        pallet = self._order.pallet
        kept = (highest <= z + LEVEL) & (z + self._size[2] + pallet.deck <= pallet.height + ROUNDED)
        area, spare, borne = self._borne(z)
        x, y = np.nonzero(kept)
        low = np.column_stack([self._at[0][x], self._at[1][y], z[x, y]])
        borne_low, borne_high = borne[:, :, x, y].transpose(0, 2, 1)
        return LandingPlaces(
            low, is_turned, area[x, y], self._beside(z)[x, y], spare[x, y], borne_low, borne_high
        )

    def _borne(self, z: Array) -> tuple[Array, Array, Array]:
        """Return, for bases at heights z, share borne and kg to spare (X, Y), and m around (2, 2, X, Y)."""
        on_deck = z == 0.0
        area, spare = on_deck.astype(float), np.full(z.shape, np.inf)
        lower = [at[:, None] if k == 0 else at[None, :] for k, at in enumerate(self._at)]
        borne = np.empty((2, 2, *z.shape))
        for k in (0, 1):
            borne[0, k] = np.where(on_deck, lower[k], np.inf)
            borne[1, k] = np.where(on_deck, lower[k] + self._size[k], -np.inf)
        placed, base = self._placed, float(self._size[0] * self._size[1])
        width = least_contact(self._order.clearance)
        for k, rows, columns in self._over:
            bears = abs(z[rows, columns] - placed.high[k, 2]) <= LEVEL
            if not bears.any():
                continue
            x, y = self._shared[0][rows, k], self._shared[1][columns, k]
            area[rows, columns] += bears * np.outer(x, y) / base
            spare[rows, columns] = np.where(
                bears, np.minimum(spare[rows, columns], placed.spare[k]), spare[rows, columns]
            )
            ends = [
                (np.maximum(at, placed.borne_low[k, axis]), np.minimum(at + side, placed.borne_high[k, axis]))
                for axis, (at, side) in enumerate(
                    ((self._at[0][rows], self._size[0]), (self._at[1][columns], self._size[1]))
                )
            ]
            is_firm = np.logical_and.outer(
                (x >= width) & (ends[0][0] <= ends[0][1]), (y >= width) & (ends[1][0] <= ends[1][1])
            )
            bears &= is_firm
            for axis, (low, high) in enumerate(ends):
                shape = (-1, 1) if axis == 0 else (1, -1)
                for side, end, better in ((0, low, np.minimum), (1, high, np.maximum)):
                    part = borne[side, axis, rows, columns]
                    part[...] = np.where(bears, better(part, end.reshape(shape)), part)
        return area, spare, borne

    def _beside(self, z: Array) -> Array:
        """Return (X, Y) m of the sides of bases within twice the clearance of others, or at the edge."""
        total, reach, placed = np.zeros(z.shape), 2 * self._order.clearance, self._placed
        for k, at in enumerate(self._at):
            size, other = float(self._size[k]), float(self._size[1 - k])
            ends = (at <= self._room[0, k] + reach).astype(float) + (at + size >= self._room[1, k] - reach)
            total += other * (ends[:, None] if k == 0 else ends[None, :])
            is_near = (-self._shared[k] >= -ROUNDED) & (-self._shared[k] <= reach)  # (., K)
            for i, j in zip(*np.nonzero(is_near), strict=True):
                line = (i, slice(None)) if k == 0 else (slice(None), i)
                is_high = (placed.low[j, 2] < z[line] + self._size[2]) & (placed.high[j, 2] > z[line])
                total[line] += is_high * np.maximum(self._shared[1 - k][:, j], 0.0)
        return total
