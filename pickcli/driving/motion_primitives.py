"""Motion primitives: short drives that end exactly on the lattice (Pivtoraiko and Kelly, IROS 2005).

A primitive has the steering angle 0 at both ends and two others at thirds of its travel: with the travel,
three figures for the three of its end pose, found by Newton's method.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pickcli.driving.tricycle import Tricycle
from pickcli.errors import InputError
from pickcli.geometry import Array

N_HEADINGS = 32
CELL = 0.1  # m between points of the lattice
TURNS = (0, 1, -1, 2, -2, 4, -4, 8, -8)  # changes of heading
LONGER = 3.5  # times the shortest drive in a heading, of a second one that does not turn
STEEPEST = 4.0  # rad of steering angle per m of travel
RANGE = 1.6  # m from the start of a primitive to its end, at most
AHEAD = 0.15  # rad of the direction to the end from the mean of both headings, at most
ITERATIONS = 9
MOST_TRAVEL = 4.0  # m
CLOSE = 1e-10  # m and rad of an end pose
DIFFERENCE = 1e-7  # of a figure, to differentiate end poses


@dataclass(frozen=True, eq=False)
class Connections:
    """Drives of three steps each.

    Attributes:
        ends: (N, 3) m, m, rad: end pose in the frame of the start.
        travel: (N,) m.
        steering: (N, 4) rad at the ends and thirds of the travel.
    """

    ends: Array
    travel: Array
    steering: Array

    def chosen(self, which: NDArray[np.intp]) -> Connections:
        """Return some of the drives.

        Args:
            which: (M,) indices.

        Returns:
            The drives.
        """
        return Connections(self.ends[which], self.travel[which], self.steering[which])


@dataclass(frozen=True, eq=False)
class HeadingPrimitives:
    """The primitives that begin in one heading of the lattice, forwards.

    Attributes:
        drives: The drives, in the frame of the truck at the start.
        cells: (N, 2) cells from start to end, in the frame of the lattice.
        turns: (N,) headings from start to end.
    """

    drives: Connections
    cells: NDArray[np.intp]
    turns: NDArray[np.intp]


def connections(truck: Tricycle, ends: Array) -> tuple[Connections, NDArray[np.intp]]:
    """Find drives forwards to end poses.

    Args:
        truck: The truck.
        ends: (N, 3) m, m, rad in the frame of the start.

    Returns:
        The drives within the limits of plans and ``STEEPEST``; the indices of their ends.
    """
    ends = np.asarray(ends, dtype=float)
    chord = np.hypot(ends[:, 0], ends[:, 1])
    travel = np.hypot(chord, truck.wheel_base * ends[:, 2])
    mean = np.arcsin(np.clip(1.3 * truck.wheel_base * ends[:, 2] / travel, -0.97, 0.97))
    figures = np.column_stack([mean, mean, travel])
    for _ in range(ITERATIONS):
        error = ends - _end(truck, figures)
        moved = figures[:, None, :] + DIFFERENCE * np.eye(3)
        slopes = (_end(truck, moved) - _end(truck, figures)[:, None, :]) / DIFFERENCE  # (N, figure, end)
        slopes = np.swapaxes(slopes, 1, 2) + 1e-12 * np.eye(3)
        change = np.linalg.solve(slopes, error[:, :, None])[:, :, 0]
        figures = figures + np.clip(change, [-0.5, -0.5, -0.3], [0.5, 0.5, 0.3])
        figures = np.clip(figures, [-1.6, -1.6, 0.02], [1.6, 1.6, MOST_TRAVEL])
    error = np.abs(ends - _end(truck, figures)).max(axis=1)
    steering = np.column_stack([np.zeros(len(ends)), figures[:, :2], np.zeros(len(ends))])
    steepest = np.abs(np.diff(steering, axis=1)).max(axis=1) / (figures[:, 2] / 3)
    is_good = (error < CLOSE) & (np.abs(steering).max(axis=1) <= truck.planned_steering)
    found = np.flatnonzero(is_good & (steepest <= STEEPEST))
    return Connections(ends[found], figures[found, 2], steering[found]), found


def _end(truck: Tricycle, figures: Array) -> Array:
    """(..., 3) end poses for (..., 3) figures: two steering angles and the travel."""
    step, zero = figures[..., 2] / 3, np.zeros(figures.shape[:-1])
    angles = (zero, figures[..., 0], figures[..., 1], zero)
    yaw, place = zero, np.zeros((*figures.shape[:-1], 2))
    for before, after in pairwise(angles):
        place = place + truck.displacement(yaw, before, after, step)
        yaw = yaw + truck.yaw_change(before, after, step)
    return np.concatenate([place, yaw[..., None]], axis=-1)


def heading_angle(heading: NDArray[np.intp] | int) -> Array:
    """Return the yaw of headings.

    Args:
        heading: (...) index of the heading.

    Returns:
        (...) rad.
    """
    return np.asarray(heading) * (2 * np.pi / N_HEADINGS)


def motion_primitives(truck: Tricycle) -> tuple[HeadingPrimitives, ...]:
    """Generate the primitives of every heading.

    For each change of heading there is the drive of the least travel, and without a change a longer one, too.
    Headings a right angle apart have the same ones, turned.

    Args:
        truck: The truck.

    Returns:
        The primitives of each heading.

    Raises:
        InputError: The truck turns in too wide curves: out of some heading none leads into the next one.
    """
    quarter = N_HEADINGS // 4
    goals = [_goals(heading) for heading in range(quarter)]
    local = np.concatenate([_in_truck_frame(heading, *goal) for heading, goal in enumerate(goals)])
    drives, found = connections(truck, local)
    of = np.repeat(np.arange(quarter), [len(turns) for _, turns in goals])[found]
    cells = np.concatenate([cells for cells, _ in goals])[found]
    turns = np.concatenate([turns for _, turns in goals])[found]
    first = []
    for heading in range(quarter):
        which = _shortest(np.flatnonzero(of == heading), turns, drives.travel)
        first.append(HeadingPrimitives(drives.chosen(which), cells[which], turns[which]))
        if not {1, -1} <= set(turns[which].tolist()):
            figures = f"a wheel base of {truck.wheel_base:g} m and {truck.steering:g} rad of steering"
            advice = "state a shorter wheel base or more steering"
            raise InputError(f"the truck turns in too wide curves for the lattice, with {figures}; {advice}")
    return tuple(_turned(first[heading % quarter], heading // quarter) for heading in range(N_HEADINGS))


def _goals(heading: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Cells (N, 2) and changes of heading (N,) at which primitives of a heading may end."""
    n = int(RANGE / CELL)
    grid = np.stack(np.meshgrid(np.arange(-n, n + 1), np.arange(-n, n + 1), indexing="ij"), -1).reshape(-1, 2)
    distance = np.hypot(*grid.T) * CELL
    direction = np.arctan2(grid[:, 1], grid[:, 0])
    cells, turns = [], []
    for turn in TURNS:
        off = direction - heading_angle(heading) - heading_angle(turn) / 2
        is_ahead = np.abs((off + np.pi) % (2 * np.pi) - np.pi) < AHEAD
        inside = grid[is_ahead & (distance > 0) & (distance <= RANGE)]
        cells.append(inside)
        turns.append(np.full(len(inside), turn))
    return np.concatenate(cells), np.concatenate(turns)


def _in_truck_frame(heading: int, cells: NDArray[np.intp], turns: NDArray[np.intp]) -> Array:
    """(N, 3) end poses in the frame of the truck at the start."""
    c, s = np.cos(heading_angle(heading)), np.sin(heading_angle(heading))
    x, y = CELL * cells[:, 0], CELL * cells[:, 1]
    return np.column_stack([c * x + s * y, c * y - s * x, heading_angle(turns)])


def _shortest(which: NDArray[np.intp], turns: NDArray[np.intp], travel: Array) -> NDArray[np.intp]:
    """Of some drives the shortest of each change of heading, and a longer one without a change."""
    kept: list[int] = []
    for turn in TURNS:
        ranked = sorted(which[turns[which] == turn].tolist(), key=lambda k: (travel[k], k))
        kept += ranked[:1]
        if turn == 0:
            kept += [k for k in ranked if travel[k] >= LONGER * travel[ranked[0]]][:1]
    return np.array(kept, dtype=np.intp)


def _turned(primitives: HeadingPrimitives, quarters: int) -> HeadingPrimitives:
    """The primitives turned by right angles."""
    x, y = primitives.cells.T
    for _ in range(quarters):
        x, y = -y, x
    return HeadingPrimitives(primitives.drives, np.stack([x, y], -1), primitives.turns)
