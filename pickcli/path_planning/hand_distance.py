"""Distance of the hand to the goals through free positions: the heuristic of searches on a workspace lattice.

One sphere of the hand is moved on the 26-connected grid of the lattice's positions (Cohen, Subramania,
Chitta and Likhachev 2011). A position where it is not free is left out for all postures, and an edge of the
lattice moves the hand by one step of the grid: what is found is never more than the edges cost, and differs
along an edge by no more than the edge costs.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from pickcli.collision.hand_sphere import HandSphereChecker
from pickcli.geometry import Array

STEPS = np.array([step for step in product((-1, 0, 1), repeat=3) if any(step)])  # (26, 3)


@dataclass(frozen=True, eq=False)
class HandGrid:
    """Positions of the hand.

    Attributes:
        origin: (3,) m, position with index 0, 0, 0 in the world.
        step: m between positions.
        lower: (3,) least indices.
        is_free: (X, Y, Z) whether the hand's sphere is free at each, from ``lower`` on.
    """

    origin: Array
    step: float
    lower: NDArray[np.int64]
    is_free: NDArray[np.bool_]

    @classmethod
    def around(cls, points: Array, step: float, room: float, sphere: HandSphereChecker | None) -> HandGrid:
        """Make the grid through the first of several points.

        Args:
            points: (P, 3) m, in the world.
            step: m between positions.
            room: m that it extends beyond all points.
            sphere: Checks positions; None leaves all free.

        Returns:
            The grid.
        """
        low = np.floor((points.min(axis=0) - room - points[0]) / step).astype(np.int64)
        high = np.ceil((points.max(axis=0) + room - points[0]) / step).astype(np.int64)
        shape = tuple((high - low + 1).tolist())
        grid = cls(points[0], step, low, np.ones(shape, dtype=bool))
        if sphere is None:
            return grid
        return cls(points[0], step, low, sphere.are_free(grid.positions).reshape(shape))

    @property
    def positions(self) -> Array:
        """(X * Y * Z, 3) m, all positions in the world."""
        indices = np.indices(self.is_free.shape).reshape(3, -1).T + self.lower
        return np.asarray(self.origin + self.step * indices)

    def distances(self, goals: Array, near: float) -> Array:
        """Compute for each position the least way to any goal.

        Args:
            goals: (G, 3) m, in the world.
            near: m within which a goal is reached straight from any position.

        Returns:
            (X, Y, Z) m; infinite where there is no way.
        """
        from scipy.sparse import coo_array  # slow to import; only for searches on a lattice
        from scipy.sparse.csgraph import dijkstra

        n = self.is_free.size
        index = np.arange(n).reshape(self.is_free.shape)
        rows, columns, lengths = self._edges(index)
        last = self._last_steps(goals, near)
        entries = np.flatnonzero((last < np.inf) & self.is_free.ravel())
        rows, columns = np.append(rows, np.full(len(entries), n)), np.append(columns, entries)
        # A length of 0 would be no edge.
        lengths = np.append(lengths, np.maximum(last[entries], 1e-12))
        graph = coo_array((lengths, (rows, columns)), shape=(n + 1, n + 1)).tocsr()
        found: Array = dijkstra(graph, directed=False, indices=n)[:n]
        return found.reshape(self.is_free.shape)

    def _edges(self, index: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
        """Return both ends and the length of every edge, each edge once."""
        rows, columns, lengths = [], [], []
        for step in STEPS[len(STEPS) // 2 :]:
            here = tuple(
                slice(max(0, -d), size - max(0, d)) for d, size in zip(step, index.shape, strict=True)
            )
            there = tuple(
                slice(max(0, d), size - max(0, -d)) for d, size in zip(step, index.shape, strict=True)
            )
            both = self.is_free[here] & self.is_free[there]
            rows.append(index[here][both])
            columns.append(index[there][both])
            lengths.append(np.full(int(both.sum()), self.step * float(np.linalg.norm(step))))
        return np.concatenate(rows), np.concatenate(columns), np.concatenate(lengths)

    def _last_steps(self, goals: Array, near: float) -> Array:
        """Return the distance (X * Y * Z,) of each position to the nearest goal, infinite if none is near."""
        positions = self.positions
        last = np.full(len(positions), np.inf)
        for goal in goals:
            last = np.minimum(last, np.linalg.norm(positions - goal, axis=1))
        return np.where(last <= near, last, np.inf)
