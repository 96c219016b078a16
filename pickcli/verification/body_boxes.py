"""Bounding boxes of rigid bodies, which say what may be in contact and what is below what."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.geometry import Array
from pickcli.verification.equilibrium import RigidBody


@dataclass(frozen=True, eq=False)
class BodyBoxes:
    """Bodies with their axis-aligned bounding boxes in the world.

    Attributes:
        bodies: N of them.
        low: (N, 3) m, their least coordinates.
        high: (N, 3) m, their greatest.
    """

    bodies: tuple[RigidBody, ...]
    low: Array
    high: Array

    @classmethod
    def around(cls, bodies: Sequence[RigidBody]) -> BodyBoxes:
        """Build the boxes of bodies.

        Args:
            bodies: The bodies.

        Returns:
            Their boxes.
        """
        middles = np.array([body.T[:3, 3] for body in bodies])
        reach = np.array([body.shape.reach(body.T[:3, :3]) for body in bodies])
        return cls(tuple(bodies), middles - reach, middles + reach)

    def near(self, k: int, reach: float) -> Iterator[RigidBody]:
        """Return later bodies whose boxes are within a reach, plus their own bounds, of the box of a body.

        Args:
            k: Index of the body.
            reach: m.

        Yields:
            The bodies.
        """
        margin = reach + np.array([[other.bound] for other in self.bodies])
        is_near = np.all((self.low <= self.high[k] + margin) & (self.high >= self.low[k] - margin), axis=1)
        return (self.bodies[i] for i in np.flatnonzero(is_near) if i > k)

    def next_below(self, k: int) -> RigidBody | None:
        """Return the body that another would fall on: the one with the highest top of those below its box.

        Args:
            k: Index of the other.

        Returns:
            The body; None without any.
        """
        is_under = np.all((self.low < self.high[k])[:, :2] & (self.high > self.low[k])[:, :2], axis=1)
        is_under &= (self.low + self.high)[:, 2] < (self.low + self.high)[k, 2]
        tops = np.where(is_under, self.high[:, 2], -np.inf)
        return self.bodies[int(np.argmax(tops))] if is_under.any() else None
