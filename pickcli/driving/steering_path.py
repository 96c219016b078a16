"""A path of the truck, as few control actions: steering angles at knots of travel, linear between them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pickcli.driving.tricycle import Tricycle
from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class SteeringPath:
    """A path that obeys the kinematics of the truck exactly, for any figures of steering.

    Attributes:
        truck: The truck.
        start: (3,) m, m, rad: pose of the truck at the start.
        steps: (K,) m of travel of the steered wheel from knot to knot, negative backwards, none 0.
        steering: (K + 1,) rad: steering angle at each knot.
    """

    truck: Tricycle
    start: Array
    steps: Array
    steering: Array

    @cached_property
    def knots(self) -> Array:
        """(K + 1,) m: travel up to each knot, either way counted positive."""
        return np.concatenate([[0.0], np.abs(self.steps).cumsum()])

    @property
    def length(self) -> float:
        """Travel (m) of the steered wheel."""
        return float(self.knots[-1])

    @cached_property
    def knot_poses(self) -> Array:
        """(K + 1, 3) m, m, rad: pose at each knot; yaw is not wrapped."""
        before, after = self.steering[:-1], self.steering[1:]
        turns = self.truck.yaw_change(before, after, self.steps)
        yaw = self.start[2] + np.concatenate([[0.0], turns.cumsum()])
        moves = self.truck.displacement(yaw[:-1], before, after, self.steps)
        places = self.start[:2] + np.concatenate([np.zeros((1, 2)), moves.cumsum(axis=0)])
        return np.column_stack([places, yaw])

    @property
    def end(self) -> Array:
        """(3,) m, m, rad: pose at the end; yaw is not wrapped."""
        last: Array = self.knot_poses[-1]
        return last

    @cached_property
    def cusps(self) -> NDArray[np.intp]:
        """Indices of the knots at which the truck changes between forwards and backwards."""
        return np.flatnonzero(np.diff(np.sign(self.steps))) + 1

    def _steps_at(self, travel: Array) -> tuple[NDArray[np.intp], Array]:
        """Index of the step in which each travel lies, and m signed travel since its begin."""
        k = np.clip(np.searchsorted(self.knots, travel, side="right") - 1, 0, len(self.steps) - 1)
        return k, (travel - self.knots[k]) * np.sign(self.steps[k])

    def steering_at(self, travel: Array) -> Array:
        """Return steering angles along the path.

        Args:
            travel: (N,) m from the start.

        Returns:
            (N,) rad.
        """
        return np.interp(travel, self.knots, self.steering)

    def poses_at(self, travel: Array) -> Array:
        """Return poses along the path.

        Args:
            travel: (N,) m from the start.

        Returns:
            (N, 3) m, m, rad.
        """
        k, part = self._steps_at(travel)
        before, now = self.steering[k], self.steering_at(travel)
        yaw = self.knot_poses[k, 2]
        moved = self.knot_poses[k, :2] + self.truck.displacement(yaw, before, now, part)
        return np.column_stack([moved, yaw + self.truck.yaw_change(before, now, part)])

    def divided(self, travel: float) -> tuple[SteeringPath, SteeringPath]:
        """Divide the path.

        Args:
            travel: m from the start, between start and end.

        Returns:
            What is before, and what is after it.
        """
        k = int(np.clip(np.searchsorted(self.knots, travel, side="right") - 1, 0, len(self.steps) - 1))
        part = float((travel - self.knots[k]) * np.sign(self.steps[k]))
        steering = self.steering_at(np.array([travel]))
        whole = [self.steps[k] - part] if part else [self.steps[k]]
        before = SteeringPath(
            self.truck, self.start, np.concatenate([self.steps[:k], [part] if part else []]),
            np.concatenate([self.steering[: k + 1], steering if part else []]),
        )  # fmt: skip
        after = SteeringPath(
            self.truck, self.poses_at(np.array([travel]))[0], np.concatenate([whole, self.steps[k + 1 :]]),
            np.concatenate([steering, self.steering[k + 1 :]]),
        )  # fmt: skip
        return before, after

    def then(self, other: SteeringPath) -> SteeringPath:
        """Return the path followed by another one, which begins where it ends.

        Args:
            other: Its first steering angle is the last one of this path.

        Returns:
            The whole.
        """
        return SteeringPath(
            self.truck, self.start, np.concatenate([self.steps, other.steps]),
            np.concatenate([self.steering, other.steering[1:]]),
        )  # fmt: skip


def posed(pose: Array, local: Array) -> Array:
    """Return poses that are given in the frame of another pose.

    Args:
        pose: (3,) or (..., 3) m, m, rad: the frame.
        local: (..., 3) m, m, rad in it.

    Returns:
        (..., 3) m, m, rad in the frame of ``pose``'s own.
    """
    c, s = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    x, y = local[..., 0], local[..., 1]
    return np.stack(
        [pose[..., 0] + c * x - s * y, pose[..., 1] + s * x + c * y, pose[..., 2] + local[..., 2]], -1
    )


def seen_from(pose: Array, other: Array) -> Array:
    """Return a pose in the frame of another one: the inverse of ``posed``.

    Args:
        pose: (3,) or (..., 3) m, m, rad: the frame.
        other: (..., 3) m, m, rad, in the same frame as ``pose``.

    Returns:
        (..., 3) m, m, rad in the frame ``pose``; yaw is not wrapped.
    """
    c, s = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    x, y = other[..., 0] - pose[..., 0], other[..., 1] - pose[..., 1]
    return np.stack([c * x + s * y, c * y - s * x, other[..., 2] - pose[..., 2]], -1)


def wrapped(angle: Array) -> Array:
    """Wrap angles to a turn.

    Args:
        angle: (...) rad.

    Returns:
        (...) rad in [-pi, pi).
    """
    return (angle + np.pi) % (2 * np.pi) - np.pi
