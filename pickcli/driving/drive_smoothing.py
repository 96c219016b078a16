"""Smooths a path of the lattice by trajectory optimisation with few control actions.

Between two cusps all steps are of one length. Unknown are these lengths and the steering angles at the knots.
First they are made to follow the path of the lattice; then least squares weigh travel against steering, with
the end pose and the distances from everything as penalties.
Newton's method then meets the end exactly; the result counts only if it is proven free. The lattice path is
feasible itself and remains where nothing better is proven.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.driving.free_space_proof import first_encounter
from pickcli.driving.state_lattice import StateLattice
from pickcli.driving.steering_path import SteeringPath, seen_from, wrapped
from pickcli.geometry import Array

ACTION_STEP = 0.5  # m of travel between two control actions, at most
LEAST_ACTIONS = 4  # of a part between two cusps
SHORTEST = 0.05  # m of travel of such a part, at least
SAMPLES = 3  # of a step, at which distances are weighed
STEERING_WEIGHT = 0.06  # m of travel that a change of 1 rad over 1 m counts as
END_WEIGHT = 10.0  # 1 / m
AIMS = ((0.02, 10.0), (0.03, 40.0), (0.06, 40.0))
"""What is tried one after the other: m that is aimed at over the margin, and its weight in 1 / m."""

MOST_ITERATIONS = 80
FIRST_DAMPING = 1e-3
MOST_DAMPING = 1e6
LEAST_GAIN = 1e-5  # of the squares, by which an iteration must reduce them
DIFFERENCE = 1e-6  # of an unknown, to differentiate
NEWTON_STEPS = 8
CLOSE = 1e-9  # m and rad of the end pose
DECIMALS = 9  # of control actions, as in files


@dataclass(frozen=True, eq=False)
class _Shape:
    """How unknowns make a path: its parts between cusps, and what is known."""

    signs: Array  # (S,) 1 forwards, -1 backwards
    counts: NDArray[np.intp]  # (S,) steps of each part
    first: float  # rad of steering at the start; at the end it is 0

    @classmethod
    def of(cls, path: SteeringPath) -> tuple[_Shape, Array]:
        """The shape for a path, and the unknowns that are nearest to it."""
        ends = np.array([0, *path.cusps.tolist(), len(path.steps)])
        lengths = np.diff(path.knots[ends])
        counts = np.maximum(np.ceil(lengths / ACTION_STEP).astype(np.intp), LEAST_ACTIONS)
        shape = cls(np.sign(path.steps[ends[:-1]]), counts, float(path.steering[0]))
        travel = np.abs(shape.steps(lengths[None])[0]).cumsum()[:-1]
        return shape, np.concatenate([path.steering_at(travel), lengths])

    def steps(self, lengths: Array) -> Array:
        """(B, K) signed m for (B, S) m of the parts."""
        return np.repeat(self.signs * lengths / self.counts, self.counts, axis=1)

    def split(self, unknowns: Array) -> tuple[Array, Array]:
        """(B, K) m of steps and (B, K + 1) rad of steering for (B, U) unknowns."""
        n = int(self.counts.sum()) - 1
        zero = np.zeros((len(unknowns), 1))
        return self.steps(unknowns[:, n:]), np.concatenate([zero + self.first, unknowns[:, :n], zero], axis=1)


class _Paths:
    """Many paths at once, of different unknowns."""

    def __init__(self, lattice: StateLattice, shape: _Shape) -> None:
        self.lattice, self.shape = lattice, shape
        self.start = seen_from(lattice.goal, lattice.area.start)

    def poses(self, steps: Array, steering: Array) -> Array:
        """(B, K * SAMPLES, 3) poses in the frame of the lattice, the last one at the end."""
        truck = self.lattice.area.truck
        turns = truck.yaw_change(steering[:, :-1], steering[:, 1:], steps)
        yaw = self.start[2] + np.concatenate([np.zeros((len(steps), 1)), turns.cumsum(axis=1)], axis=1)
        part = steps[:, :, None] * np.arange(1, SAMPLES + 1) / SAMPLES
        before = np.broadcast_to(steering[:, :-1, None], part.shape)
        after = before + np.diff(steering, axis=1)[:, :, None] * np.arange(1, SAMPLES + 1) / SAMPLES
        moves = truck.displacement(np.broadcast_to(yaw[:, :-1, None], part.shape), before, after, part)
        begins = np.zeros((*steps.shape, 2))
        begins[:, 1:] = moves[:, :-1, -1].cumsum(axis=1)
        places = self.start[:2] + begins[:, :, None] + moves
        angles = yaw[:, :-1, None] + truck.yaw_change(before, after, part)
        return np.concatenate([places, angles[..., None]], -1).reshape(len(steps), -1, 3)

    def end_error(self, unknowns: Array) -> Array:
        """(B, 3) m and rad at the end."""
        error = self.poses(*self.shape.split(unknowns))[:, -1].copy()
        error[:, 2] = wrapped(error[:, 2])
        return error


class _Followed(_Paths):
    """Residuals of following a path with the few actions that there are, from where they lead elsewhere."""

    def __init__(self, lattice: StateLattice, shape: _Shape, path: SteeringPath, first: Array) -> None:
        super().__init__(lattice, shape)
        steps = np.abs(shape.split(first[None])[0][0])
        parts = steps[:, None] * np.arange(1, SAMPLES + 1) / SAMPLES
        travel = (steps.cumsum() - steps)[:, None] + parts
        self.poses_to_follow = seen_from(lattice.goal, path.poses_at(travel.ravel()))

    def __call__(self, unknowns: Array) -> Array:
        steps, steering = self.shape.split(unknowns)
        off = self.poses(steps, steering) - self.poses_to_follow
        return np.concatenate([END_WEIGHT * off.reshape(len(steps), -1), _changes(steps, steering)], axis=1)


class _Residuals(_Paths):
    """Residuals of a short path with little steering that keeps away from everything."""

    def __init__(self, lattice: StateLattice, shape: _Shape, clearance: float, weight: float) -> None:
        super().__init__(lattice, shape)
        self.needed, self.weight = lattice.radius + clearance, weight

    def __call__(self, unknowns: Array) -> Array:
        steps, steering = self.shape.split(unknowns)
        poses = self.poses(steps, steering)
        distances = self.lattice.distance_at(self.lattice.disc_places(poses))
        lacking = np.maximum(self.needed - distances, 0.0)
        end = np.concatenate([poses[:, -1, :2], wrapped(poses[:, -1, 2:])], axis=1)
        return np.concatenate(
            [
                np.sqrt(unknowns[:, -len(self.shape.counts) :]),
                _changes(steps, steering),
                END_WEIGHT * end,
                self.weight * lacking.reshape(len(steps), -1),
            ],
            axis=1,
        )


def _changes(steps: Array, steering: Array) -> Array:
    """(B, K) residuals of steering less."""
    changes: Array = np.sqrt(STEERING_WEIGHT / np.abs(steps)) * np.diff(steering, axis=1)
    return changes


def smooth_path(lattice: StateLattice, path: SteeringPath) -> SteeringPath | None:
    """Make a smooth path to the goal of a lattice that is like another one.

    Args:
        lattice: The lattice, of an area in which the path starts.
        path: A path that ends at the goal or near it, of any steering at its start.

    Returns:
        A path from the same start and steering, proven to keep the margin of the area, within the limits of
        plans; None if none is proven.
    """
    shape, first = _Shape.of(path)
    n = int(shape.counts.sum()) - 1
    most = lattice.area.truck.planned_steering
    low = np.concatenate([np.full(n, -most), np.full(len(first) - n, SHORTEST)])
    high = np.concatenate([np.full(n, most), np.full(len(first) - n, np.inf)])
    followed = _Followed(lattice, shape, path, first)
    near = _least_squares(followed, np.clip(first, low, high), low, high)
    for clearance, weight in AIMS:
        residuals = _Residuals(lattice, shape, clearance, weight)
        exact = _met(residuals, _least_squares(residuals, near, low, high), low, high)
        if exact is None:
            continue
        steps, steering = shape.split(exact[None])
        smooth = SteeringPath(path.truck, path.start, steps[0].round(DECIMALS), steering[0].round(DECIMALS))
        if first_encounter(lattice.area, smooth, lattice.area.margin) is None:
            return smooth
    return None


def _least_squares(of: Callable[[Array], Array], x: Array, low: Array, high: Array) -> Array:
    """Unknowns within bounds with locally least squares of residuals, by Levenberg and Marquardt's method.

    Without a library: theirs decompose tall matrices on several threads, which wait for each other.
    """
    damping = FIRST_DAMPING
    cost = float((of(x[None]) ** 2).sum())
    for _ in range(MOST_ITERATIONS):
        moved = of(np.concatenate([x[None], x + DIFFERENCE * np.eye(len(x))]))
        slopes = (moved[1:] - moved[0]) / DIFFERENCE
        descent = -np.einsum("ur,r->u", slopes, moved[0])
        is_free = ~((x <= low) & (descent < 0) | (x >= high) & (descent > 0))
        squares = np.einsum("ur,vr->uv", slopes[is_free], slopes[is_free])
        while damping < MOST_DAMPING:
            change = np.linalg.solve(squares + damping * np.diag(squares.diagonal()), descent[is_free])
            tried = x.copy()
            tried[is_free] += change
            tried = np.clip(tried, low, high)
            new_cost = float((of(tried[None]) ** 2).sum())
            if new_cost < cost:
                break
            damping *= 4
        else:
            return x
        gain, x, cost, damping = cost - new_cost, tried, new_cost, damping / 4
        if gain < LEAST_GAIN * cost:
            return x
    return x


def _met(of: _Paths, x: Array, low: Array, high: Array) -> Array | None:
    """Unknowns nearby with which the end is met within the bounds; None if Newton's method finds none."""
    for _ in range(NEWTON_STEPS):
        moved = of.end_error(np.concatenate([x[None], x + DIFFERENCE * np.eye(len(x))]))
        if np.abs(moved[0]).max() < CLOSE:
            return x
        is_free = (x > low + 1e-6) & (x < high - 1e-6)
        slopes = ((moved[1:] - moved[0]).T / DIFFERENCE)[:, is_free]
        x = x.copy()
        x[is_free] -= np.linalg.lstsq(slopes, moved[0], rcond=None)[0]
        x = np.clip(x, low, high)
    return None
