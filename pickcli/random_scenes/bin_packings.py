"""Many alternative packings of one bin as arrays, modified by moving one item at a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.geometry import Array
from pickcli.random_scenes.box_arrays import Bools, BoxArrays, lies_on
from pickcli.random_scenes.crowding_cost import crowding
from pickcli.random_scenes.extraction_access import have_way_out
from pickcli.random_scenes.leaning_placements import LeanKind, leaning_placements
from pickcli.random_scenes.placement_sampling import Indices, Placements, from_corner, random_placements

NONE_LEANS: Mapping[int, Sequence[LeanKind]] = MappingProxyType({})
N_SPOTS = 6  # placements drawn per move in each packing
BLOCKED = 8.0  # cost of an item that cannot be extracted
OUTSIDE_COST = 1000.0  # cost of an item that is not in the bin yet
WAITING_BOX = np.array([[10.0, 0.0, 0.0], [10.01, 0.01, 0.01]])  # m, box of such an item, far behind the bin
WASTE = 20.0  # cost per m of distance from the corner while cramming


@dataclass(eq=False)
class BinPackings:
    """F alternative packings of a bin with the same M items.

    Attributes:
        cell_bin: The bin.
        items: The M items.
        lying: (F, M) placements of the items.
        cost: (F,) of the placements, and of order and access.
        is_cramming: (F,) whether only space is saved, until all items are in.
        may_raise: Whether items may be higher than the mouth.
        leaning: Indices of the items that are to lean, each with how it may.
    """

    cell_bin: Place
    items: Sequence[Item]
    lying: Placements
    cost: Array
    is_cramming: Bools
    may_raise: bool
    leaning: Mapping[int, Sequence[LeanKind]]

    @classmethod
    def empty(
        cls,
        cell_bin: Place,
        items: Sequence[Item],
        n: int,
        may_raise: bool,
        leaning: Mapping[int, Sequence[LeanKind]] = NONE_LEANS,
    ) -> BinPackings:
        """Create packings with all items outside.

        Every other packing starts with regard to order, the rest by cramming.

        Args:
            cell_bin: The bin.
            items: The items.
            n: Number of packings.
            may_raise: Whether items may be higher than the mouth.
            leaning: Indices of the items that are to lean, each with how it may.

        Returns:
            The packings.
        """
        shape = (n, len(items))
        low, high = (np.tile(corner, (*shape, 1)) for corner in WAITING_BOX)
        lying = Placements(
            np.zeros((*shape, 3, 3)), low.copy(), BoxArrays(low, high), np.zeros(shape),
            np.zeros(shape, bool), np.full(shape, OUTSIDE_COST), np.full(shape, -1, dtype=np.intp),
        )  # fmt: skip
        return cls(cell_bin, items, lying, np.full(n, np.inf), np.arange(n) % 2 == 1, may_raise, leaning)

    def holds(self, k: int) -> Bools:
        """Whether each packing contains an item.

        Args:
            k: Index of the item.

        Returns:
            (F,).
        """
        return np.asarray(self.lying.own[:, k] < OUTSIDE_COST)

    def is_full(self) -> Bools:
        """Whether each packing contains all items.

        Returns:
            (F,).
        """
        return np.asarray((self.lying.own < OUTSIDE_COST).all(axis=1))

    def poses(self, packing: int) -> Array:
        """Return the poses of all items of one packing.

        Args:
            packing: Index of the packing.

        Returns:
            ``T_bin_item`` (M, 4, 4).
        """
        T = np.tile(np.eye(4), (len(self.items), 1, 1))
        T[:, :3, :3], T[:, :3, 3] = self.lying.R[packing], self.lying.centre[packing]
        return T

    def move(self, k: int, rng: np.random.Generator, tolerance: float = 0.0) -> None:
        """Move an item in every packing whose cost decreases, or increases by about the tolerance at most.

        Args:
            k: Index of the item.
            rng: Source of random numbers.
            tolerance: Cost.
        """
        of = np.repeat(np.arange(len(self.cost)), N_SPOTS)
        there = self._without(k, of)
        if k in self.leaning:
            spots = leaning_placements(self.cell_bin, self.items, k, there, self.leaning[k], rng)
        else:
            spots = random_placements(
                self.cell_bin, self.items[k], there, self.is_cramming[of], self.may_raise, rng
            )
        own = there.own.sum(axis=1) - there.own[:, k] + spots.own
        own[self._carries(k)[of]] = np.inf
        limit = self.cost + tolerance * rng.exponential(size=len(self.cost))
        cost = self._costs(there.boxes.replaced(k, spots.boxes), own, self.is_cramming[of], limit[of])
        best = cost.reshape(-1, N_SPOTS).argmin(axis=1) + N_SPOTS * np.arange(len(self.cost))
        rows = np.flatnonzero(cost[best] < limit)
        for mine, new in zip(_parts(self.lying), _parts(spots), strict=True):
            mine[rows, k] = new[best[rows]]
        self.cost[rows] = cost[best[rows]]

    def tidy_up(self) -> None:
        """Consider order from now on in the packings that contain all items."""
        rows = np.flatnonzero(self.is_cramming & self.is_full())
        self.is_cramming[rows] = False
        own, any_cost = self.lying.own[rows].sum(axis=1), np.full(len(rows), np.inf)
        self.cost[rows] = self._costs(self.lying.boxes[rows], own, self.is_cramming[rows], any_cost)

    def copy(self, of: Indices, to: Indices) -> None:
        """Replace some packings by copies of others.

        Args:
            of: Indices of the copied packings.
            to: Indices of the replaced packings.
        """
        for part in (*_parts(self.lying), self.cost, self.is_cramming):
            part[to] = part[of]

    def _without(self, k: int, of: Indices) -> Placements:
        """Placements in packings ``of`` without item k."""
        lying = self.lying
        boxes = lying.boxes[of].replaced(k, BoxArrays(*WAITING_BOX))
        return Placements(
            lying.R[of], lying.centre[of], boxes, lying.pitch[of], lying.is_level[of], lying.own[of],
            lying.leans_on[of],
        )  # fmt: skip

    def _carries(self, k: int) -> Bools:
        """Whether something lies or leans on item k in each packing (F,)."""
        boxes = self.lying.boxes
        return np.asarray((lies_on(boxes, boxes[:, k : k + 1]) | (self.lying.leans_on == k)).any(axis=1))

    def _costs(self, boxes: BoxArrays, own: Array, is_cramming: Bools, limit: Array) -> Array:
        """Cost of rows of boxes; access is checked only in rows that are below their limit otherwise."""
        wasted = WASTE * from_corner(self.cell_bin, boxes).sum(axis=-1)
        cost = own + np.where(is_cramming, wasted, crowding(self.cell_bin, boxes))
        rows = np.flatnonzero((cost < limit) & ~is_cramming)
        cost[rows] += BLOCKED * (~have_way_out(self.cell_bin, boxes[rows])).sum(axis=-1)
        return np.asarray(cost)


def _parts(lying: Placements) -> tuple[NDArray[Any], ...]:
    boxes = lying.boxes
    return (
        lying.R, lying.centre, boxes.low, boxes.high, lying.pitch, lying.is_level, lying.own, lying.leans_on,
    )  # fmt: skip
