"""A* on the state lattice, with a heuristic that is admissible and consistent."""

from __future__ import annotations

from dataclasses import dataclass
from heapq import heappop, heappush

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from pickcli.driving.free_space_proof import first_encounter
from pickcli.driving.motion_primitives import CELL, N_HEADINGS, heading_angle
from pickcli.driving.state_lattice import FINE, LatticeEdges, StateLattice
from pickcli.driving.steering_path import SteeringPath, wrapped
from pickcli.geometry import Array

CUSP_COST = 1.0  # m of travel that a change between forwards and backwards counts as
LEAST_GAIN = 1e-12  # m by which another way to a state must cost less
MOST_EXPANSIONS = 400_000
OCTILE = float(np.cos(np.pi / 8))  # least ratio of a straight line to the way along eight directions


@dataclass(frozen=True, eq=False)
class LatticePath:
    """The best path on the lattice.

    Attributes:
        path: The path.
        cost: m of travel, with ``CUSP_COST`` for each change of direction.
        n_expanded: Number of states whose edges were looked at.
    """

    path: SteeringPath
    cost: float
    n_expanded: int


def least_travel(lattice: StateLattice) -> Array:
    """Return for every cell the least way of the middle of the axle to the goal, past everything.

    A curve through cells of which all four corners are allowed is at least ``OCTILE`` times as long as the
    shortest way along sides and diagonals of these cells: values at corners, linear on sides and diagonals,
    differ across a cell by at most 1 / OCTILE of the distance. A corner is allowed if a point where the
    inner disc of the truck keeps the margin may be within its cell, a diagonal of a cell away.

    Args:
        lattice: The lattice.

    Returns:
        (cells, cells) m; infinite where there is no way.
    """
    n_x, n_y = lattice.shape
    radius = lattice.area.truck.inner_radius + lattice.area.margin
    is_free = lattice.distances[::FINE, ::FINE] > radius - CELL * np.sqrt(2) - 1e-3
    index = np.arange(n_x * n_y).reshape(n_x, n_y)
    rows, columns, lengths = [], [], []
    for i, j in ((1, 0), (0, 1), (1, 1), (1, -1)):
        here = (slice(0, n_x - i), slice(max(0, -j), n_y - max(0, j)))
        there = (slice(i, n_x), slice(max(0, j), n_y - max(0, -j)))
        both = is_free[here] & is_free[there]
        rows.append(index[here][both])
        columns.append(index[there][both])
        lengths.append(np.full(int(both.sum()), CELL * np.hypot(i, j)))
    graph = coo_array(
        (np.concatenate(lengths), (np.concatenate(rows), np.concatenate(columns))), shape=(n_x * n_y,) * 2
    ).tocsr()
    found = dijkstra(graph, directed=False, indices=int(index[tuple(lattice.origin)]))
    least: Array = OCTILE * found.reshape(n_x, n_y)
    return least


class LatticeSearch:
    """A search from a start to the goal of a lattice.

    A state is a point of the lattice with the direction in which the truck came. The heuristic joins two
    bounds: travel ds of the steered wheel moves the axle by ds cos(phi) and turns the truck by
    ds sin(phi) / L, so that travel is at least the hypotenuse of the axle's least way and of L times the
    least turn.

    Args:
        lattice: The lattice.
        start: (3,) m, m, rad: pose of the truck.
    """

    def __init__(self, lattice: StateLattice, start: Array) -> None:
        self.lattice, self.start = lattice, start
        turn = np.abs(wrapped(heading_angle(np.arange(N_HEADINGS))))
        least = least_travel(lattice).ravel()[:, None]
        self.heuristic: Array = np.hypot(least, lattice.area.truck.wheel_base * turn).ravel()
        n_states = 2 * N_HEADINGS * lattice.shape[0] * lattice.shape[1]
        self.costs: Array = np.full(n_states + 1, np.inf)
        self.came_from: NDArray[np.int64] = np.full(n_states + 1, -1)
        self.edge: NDArray[np.int32] = np.full(n_states + 1, -1, dtype=np.int32)
        self.queue: list[tuple[float, int]] = []
        self.n_expanded = self.n_out = 0  # states looked at; free edges out of the start
        self.free: dict[int, NDArray[np.bool_]] = {}  # which edges of a point of the lattice are free
        self.started: LatticeEdges | None = None

    def run(self) -> LatticePath | None:
        """Search from the start to the goal.

        Returns:
            The path of least cost on the lattice; None if there is none.
        """
        self.started = self.lattice.start_edges(self.start)
        if self.started is not None:
            i, j = self.lattice.origin.tolist()
            is_free = self._free_out(self.started)
            self.n_out = int(is_free.sum())
            self._relax(-1, self.started, (i, j), is_free, None)
        is_closed = np.zeros(len(self.costs), dtype=bool)
        goal = len(self.costs) - 1
        i, j = self.lattice.origin.tolist()
        at_goal = ((i * self.lattice.shape[1] + j) * N_HEADINGS) * 2
        wanted = int(np.sign(self.lattice.area.straight))
        while self.queue and self.n_expanded < MOST_EXPANSIONS:
            _, state = heappop(self.queue)
            if is_closed[state]:
                continue
            is_closed[state] = True
            if state == goal:
                return LatticePath(self._path(), float(self.costs[goal]), self.n_expanded)
            if state // 2 * 2 == at_goal:
                self._finish(state, bool(wanted) and (state % 2 == 1) != (wanted > 0))
            self._expand(state)
        return None

    def _free_out(self, edges: LatticeEdges) -> NDArray[np.bool_]:
        """Which edges out of the start are free: by exact shapes if by discs, which are quicker, none is."""
        is_free = self.lattice.are_free(edges)
        if is_free.any():
            return is_free
        area = self.lattice.area
        paths = (SteeringPath(area.truck, self.start, *edges.path(k)) for k in range(len(edges.directions)))
        return np.array([first_encounter(area, path, area.margin) is None for path in paths])

    def _finish(self, state: int, has_cusp: bool) -> None:
        """Go on from the goal's point to the end, with a cusp where the straight part after it needs one."""
        cost = float(self.costs[state]) + CUSP_COST * has_cusp
        if cost < self.costs[-1]:
            self.costs[-1], self.came_from[-1] = cost, state
            heappush(self.queue, (cost, len(self.costs) - 1))

    def _expand(self, state: int) -> None:
        self.n_expanded += 1
        place, direction = divmod(state, 2)
        cell, heading = divmod(place, N_HEADINGS)
        edges = self.lattice.edges[heading]
        at = divmod(cell, self.lattice.shape[1])
        if (free := self.free.get(place)) is None:
            free = self.free[place] = self.lattice.are_free(edges, at)
        self._relax(state, edges, at, free, direction)

    def _relax(
        self,
        state: int,
        edges: LatticeEdges,
        cell: tuple[int, int],
        is_free: NDArray[np.bool_],
        direction: int | None,
    ) -> None:
        """Reach the ends of free edges of a state, of -1 the start, if they were not reached at less cost."""
        place = (cell[0] * self.lattice.shape[1] + cell[1]) * N_HEADINGS + edges.places
        ends = 2 * place + edges.directions
        reached = edges.travel + (self.costs[state] if state >= 0 else 0.0)
        if direction is not None:
            reached = reached + CUSP_COST * (edges.directions != direction)
        better = np.flatnonzero(is_free & (reached < self.costs[ends] - LEAST_GAIN))
        bounds = self.heuristic[place[better]]
        found = zip(
            ends[better].tolist(), reached[better].tolist(), bounds.tolist(), better.tolist(), strict=True
        )
        for end, at, bound, k in found:
            if bound < np.inf and at < self.costs[end]:
                self.costs[end], self.came_from[end], self.edge[end] = at, state, k
                heappush(self.queue, (at + bound, end))

    def _path(self) -> SteeringPath:
        parts: list[tuple[Array, Array]] = []
        state = int(self.came_from[-1])
        while state >= 0:
            before = int(self.came_from[state])
            edges = self.started if before < 0 else self.lattice.edges[before // 2 % N_HEADINGS]
            assert edges is not None
            parts.append(edges.path(int(self.edge[state])))
            state = before
        steps = np.concatenate([steps for steps, _ in reversed(parts)])
        steering = np.concatenate([[0.0], *(angles[1:] for _, angles in reversed(parts))])
        return SteeringPath(self.lattice.area.truck, self.start, steps, steering)
