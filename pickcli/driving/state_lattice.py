"""The state lattice: positions and headings around the goal, and the edges between them that are proven free.

The truck is covered by discs, whose distance from everything is read from a table of points. What is read is
less than the true distance by no more than the way to the nearest point of the table, and a disc moves no
farther than its bound between two samples: with both added to its radius, an edge is free all along, not only
at samples.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pickcli.driving.driving_area import DrivingArea
from pickcli.driving.motion_primitives import (
    AHEAD,
    CELL,
    MOST_TRAVEL,
    N_HEADINGS,
    RANGE,
    Connections,
    connections,
    heading_angle,
    motion_primitives,
)
from pickcli.driving.steering_path import SteeringPath, posed, seen_from, wrapped
from pickcli.driving.tricycle import Tricycle
from pickcli.geometry import Array

Indices = NDArray[np.intp]

FINE = 4  # points of the table of distances in a cell of the lattice, either way
SAMPLE_STEP = 0.06  # m of travel between two samples of an edge
DISC_PITCH = (0.25, 0.45)  # m between two discs that cover the truck, at most, along and across it
FAR = 1.0  # m beyond the least distance that matters, above which distances are not told apart
START_RANGE = 1.5  # m from the start to points of the lattice that it is connected with, less than RANGE
START_TURN = 4  # headings, likewise


@dataclass(frozen=True, eq=False)
class LatticeEdges:
    """Edges out of one heading of the lattice.

    Attributes:
        places: (N,) index of the end, a cell in a heading, less that of heading 0 in the cell of the begin.
        directions: (N,) 1 forwards, 0 backwards.
        travel: (N,) m.
        steering: (N, 4) rad at the ends and thirds of the travel.
        offsets: (M,) points of the table of distances from that of the beginning, sample by sample.
        needed: (M,) m, the distance that proves each sample.
        first: (N,) index of the first sample of each edge.
    """

    places: Indices
    directions: Indices
    travel: Array
    steering: Array
    offsets: Indices
    needed: Array
    first: Indices

    def path(self, k: int) -> tuple[Array, Array]:
        """Return the control actions of an edge.

        Args:
            k: Its index.

        Returns:
            (3,) m, signed steps; (4,) rad, steering at their ends.
        """
        sign = 1.0 if self.directions[k] else -1.0
        return np.full(3, sign * self.travel[k] / 3), self.steering[k]


class StateLattice:
    """The lattice of an area. Its frame is that of the goal: the goal is a point of it, in heading 0.

    Args:
        area: The area.
        goal: (3,) m, m, rad: pose at which the lattice is anchored.
    """

    def __init__(self, area: DrivingArea, goal: Array) -> None:
        self.area, self.goal = area, goal
        truck = area.truck
        self.discs, radius = _disc_cover(truck)
        self.radius = radius + area.margin  # m from the middle of a disc that is to be free
        self.disc_sweeps = truck.sweeps(self.discs)
        corners = np.array([(x, y) for x in (area.low[0], area.high[0]) for y in (area.low[1], area.high[1])])
        local = seen_from(goal, np.column_stack([corners, np.zeros(4)]))[:, :2]
        # Edges begin within the walls: nothing that is read is farther from them than this.
        border = (MOST_TRAVEL + RANGE) / 2 + float(np.linalg.norm(truck.corners, axis=1).max()) + CELL
        low, high = np.floor((local.min(0) - border) / CELL), np.ceil((local.max(0) + border) / CELL)
        self.origin: Indices = -low.astype(np.intp)  # cell of the goal
        self.shape = tuple((high - low).astype(int) + 1)
        self.distances = self._distances()
        self._flat = self.distances.ravel()

    def _distances(self) -> NDArray[np.float32]:
        """Table of distances, (cells x FINE, cells x FINE) m, those far from everything clipped."""
        n_x, n_y = (FINE * n for n in self.shape)
        x = CELL / FINE * (np.arange(n_x) - FINE * self.origin[0])
        y = CELL / FINE * (np.arange(n_y) - FINE * self.origin[1])
        far = self.radius + FAR
        c, s = np.cos(self.goal[2]), np.sin(self.goal[2])
        world = [
            self.goal[0] + c * x[:, None] - s * y[None, :],
            self.goal[1] + s * x[:, None] + c * y[None, :],
        ]
        table = np.full((n_x, n_y), far)
        for axis, place in enumerate(world):
            np.minimum(table, place - self.area.low[axis], out=table)
            np.minimum(table, self.area.high[axis] - place, out=table)
        for box in self.area.boxes:
            corners = seen_from(self.goal, np.column_stack([box.corners, np.zeros(4)]))[:, :2]
            i = slice(*np.searchsorted(x, [corners[:, 0].min() - far, corners[:, 0].max() + far]))
            j = slice(*np.searchsorted(y, [corners[:, 1].min() - far, corners[:, 1].max() + far]))
            part = np.stack([world[0][i, j], world[1][i, j]], -1)
            table[i, j] = np.minimum(table[i, j], box.distance(part))
        # Rounded down, by far more than single precision loses.
        return (table - 1e-5).astype(np.float32)

    @cached_property
    def edges(self) -> tuple[LatticeEdges, ...]:
        """Edges of every heading, forwards and backwards."""
        primitives = motion_primitives(self.area.truck)
        # Of each heading: where a primitive begins that may be driven out of it, its index, the direction.
        onwards: list[list[tuple[int, int, int]]] = [[] for _ in range(N_HEADINGS)]
        for heading, of in enumerate(primitives):
            for k, turn in enumerate(of.turns.tolist()):
                onwards[heading].append((heading, k, 1))
                onwards[(heading + turn) % N_HEADINGS].append((heading, k, 0))
        found = []
        for heading, each in enumerate(onwards):
            drives, cells, ends = [], [], []
            for begin, k, direction in sorted(each):
                of = primitives[begin]
                forward = of.drives.chosen(np.array([k]))
                drives.append(forward if direction else _backwards(forward))
                cells.append(of.cells[k] if direction else -of.cells[k])
                ends.append((begin + of.turns[k]) % N_HEADINGS if direction else begin)
            directions = np.array([direction for *_, direction in sorted(each)])
            start = np.array([0.0, 0.0, heading_angle(heading)])
            found.append(self._edges(start, _joined(drives), directions, np.array(cells), np.array(ends)))
        return tuple(found)

    def _edges(
        self, start: Array, drives: Connections, directions: Indices, cells: Indices, headings: Indices
    ) -> LatticeEdges:
        """Edges out of a pose in the frame of the lattice, with what proves them free."""
        offsets, needed, first, n = [], [], [], 0
        n_y = FINE * self.shape[1]
        for k in range(len(directions)):
            sign = 1.0 if directions[k] else -1.0
            path = SteeringPath(
                self.area.truck, start, np.full(3, sign * drives.travel[k] / 3), drives.steering[k]
            )
            n_samples = int(np.ceil(path.length / SAMPLE_STEP))
            step = path.length / n_samples
            poses = path.poses_at((np.arange(n_samples, dtype=float) + 0.5) * step)
            places = self.disc_places(poses).reshape(-1, 2)
            points = np.rint(places * (FINE / CELL)).astype(np.intp)
            off = np.linalg.norm(places - points * (CELL / FINE), axis=1)
            offsets.append(points[:, 0] * n_y + points[:, 1])
            needed.append(self.radius + off + np.tile(step / 2 * self.disc_sweeps, n_samples))
            first.append(n)
            n += len(points)
        places = (cells[:, 0] * self.shape[1] + cells[:, 1]) * N_HEADINGS + headings
        return LatticeEdges(
            places, directions, drives.travel, drives.steering, np.concatenate(offsets),
            np.concatenate(needed).astype(np.float32), np.array(first),
        )  # fmt: skip

    def start_edges(self, start: Array) -> LatticeEdges | None:
        """Connect a pose with points of the lattice around it, forwards and backwards.

        Args:
            start: (3,) m, m, rad in the area.

        Returns:
            Edges whose ``places`` count from the origin of the lattice; None if there are none.
        """
        local = seen_from(self.goal, start)
        middle = np.rint(local[:2] / CELL).astype(np.intp)
        n = int(START_RANGE / CELL)
        grid = np.stack(np.meshgrid(*[np.arange(-n, n + 1)] * 2, indexing="ij"), -1).reshape(-1, 2) + middle
        nearest = round(float(local[2]) / float(heading_angle(1)))
        headings = np.repeat(np.arange(nearest - START_TURN, nearest + START_TURN + 1), len(grid))
        cells = np.tile(grid, (2 * START_TURN + 1, 1))
        nodes = np.column_stack([CELL * cells, heading_angle(headings)])
        drives, which, directions = [], [], []
        for direction in (1, 0):
            ends = seen_from(local, nodes) if direction else seen_from(nodes, local)
            ends[:, 2] = wrapped(ends[:, 2])
            off = np.abs(np.arctan2(ends[:, 1], ends[:, 0]) - ends[:, 2] / 2)
            distance = np.hypot(ends[:, 0], ends[:, 1])
            near = np.flatnonzero((off < AHEAD) & (distance > 1e-3) & (distance <= START_RANGE))
            forward, found = connections(self.area.truck, ends[near])
            drives.append(forward if direction else _backwards(forward))
            which.append(near[found])
            directions.append(np.full(len(found), direction))
        chosen = np.concatenate(which)
        if not len(chosen):
            return None
        return self._edges(
            local, _joined(drives), np.concatenate(directions), cells[chosen], headings[chosen] % N_HEADINGS
        )

    def are_free(self, edges: LatticeEdges, cell: tuple[int, int] | None = None) -> NDArray[np.bool_]:
        """Return which edges are proven to keep the margin of the area.

        Args:
            edges: The edges.
            cell: Cell in which they begin, of a heading of the lattice; None: of the start.

        Returns:
            (N,).
        """
        i, j = cell if cell is not None else self.origin.tolist()
        read = self._flat.take(edges.offsets + FINE * (i * FINE * self.shape[1] + j))
        return np.logical_and.reduceat(read > edges.needed, edges.first)

    def disc_places(self, poses: Array) -> Array:
        """Return where the discs are that cover the truck.

        Args:
            poses: (..., 3) m, m, rad.

        Returns:
            (..., D, 2) m: their middles.
        """
        c, s = np.cos(poses[..., 2, None]), np.sin(poses[..., 2, None])
        x, y = self.discs.T
        return np.stack([poses[..., 0, None] + c * x - s * y, poses[..., 1, None] + s * x + c * y], -1)

    def distance_at(self, points: Array) -> Array:
        """Return distances from everything, interpolated between those of the table.

        Args:
            points: (..., 2) m in the frame of the lattice; outside the table counts as its edge.

        Returns:
            (...) m, negative outside the walls; those far from everything clipped.
        """
        last = np.array(self.distances.shape) - 2
        at = np.clip(points * (FINE / CELL) + FINE * self.origin, 0.0, last + 0.999)
        i, j = at.astype(np.intp).reshape(-1, 2).T.reshape(2, *at.shape[:-1])
        u, v = at[..., 0] - i, at[..., 1] - j
        table = self.distances
        between: Array = (1 - v) * ((1 - u) * table[i, j] + u * table[i + 1, j]) + v * (
            (1 - u) * table[i, j + 1] + u * table[i + 1, j + 1]
        )
        return between

    def pose(self, cell: tuple[int, int], heading: int) -> Array:
        """Return the pose of a point of the lattice.

        Args:
            cell: Its cell.
            heading: Its heading.

        Returns:
            (3,) m, m, rad in the area.
        """
        place = CELL * (np.array(cell) - self.origin)
        return posed(self.goal, np.array([*place, heading_angle(heading)]))


def _disc_cover(truck: Tricycle) -> tuple[Array, float]:
    """(D, 2) m: middles of equal discs that cover the truck, in its frame; m: their radius."""
    sides = np.array([truck.front + truck.back, truck.width])
    n = np.ceil(sides / DISC_PITCH).astype(int)
    pitch = sides / n
    x, y = (side * (np.arange(k) + 0.5) / k for side, k in zip(sides, n, strict=True))
    middles = np.stack(np.meshgrid(x - truck.back, y - truck.width / 2, indexing="ij"), -1).reshape(-1, 2)
    return middles, float(np.hypot(*pitch) / 2)


def _joined(drives: list[Connections]) -> Connections:
    """All drives in one."""
    return Connections(
        np.concatenate([each.ends for each in drives]),
        np.concatenate([each.travel for each in drives]),
        np.concatenate([each.steering for each in drives]),
    )


def _backwards(drives: Connections) -> Connections:
    """Drives from where others end to where they begin, backwards, by the same places."""
    zero = np.zeros_like(drives.ends)
    return Connections(seen_from(drives.ends, zero), drives.travel, drives.steering[:, ::-1])
