"""Constraints on a timed path besides joint limits: second-order constraints in general position.

Along a path q(s), every quantity that is linear in accelerations and in products of velocities, like a force,
is

    a(s) u + b(s) x + c(s),    u = d2s/dt2,    x = (ds/dt)^2,

and the constraint that it stays in a convex set is a convex set in the plane of (u, x): the second-order
constraints of Pham and Pham, "A New Approach to Time-Optimal Path Parameterization Based on Reachability
Analysis", IEEE T-RO 34(3), 2018, section II.B. Rest must be allowed, so the origin is in each set.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class HalfPlanes:
    """A constraint at M places of a path: a u + b x <= c.

    Attributes:
        a: (M, R) coefficients of path acceleration u, 1/s^2 for a path in joint units.
        b: (M, R) coefficients of squared path velocity x.
        c: (M, R) without a unit, positive: rest is inside every half-plane.
    """

    a: Array
    b: Array
    c: Array


class PathConstraint(Protocol):
    """A constraint on the speed along a path."""

    def half_planes(self, q: Array, dq: Array, ddq: Array) -> HalfPlanes:
        """Return the constraint at M places of a path, or a stricter one.

        Args:
            q: (M, n) configurations.
            dq: (M, n) dq/ds.
            ddq: (M, n) d2q/ds2.

        Returns:
            The half-planes that path acceleration and squared path velocity must stay in.
        """
        ...

    def time_scale(self, q: Array, velocity: Array, acceleration: Array) -> Array:
        """Return the factor of time at which states of a motion keep the exact constraint.

        Args:
            q: (M, n) configurations.
            velocity: (M, n) per s.
            acceleration: (M, n) per s^2.

        Returns:
            (M,) at least 1; inf if not even rest keeps it.
        """
        ...

    def broken_at_rest(self, q: Array) -> str:
        """Say what is broken by rest.

        Args:
            q: (n,) configuration at which not even rest keeps the constraint.

        Returns:
            The limit, with figures where there are any.
        """
        ...


@dataclass(frozen=True)
class PathConstraints:
    """Several constraints at once.

    Attributes:
        parts: The constraints, at least one.
    """

    parts: tuple[PathConstraint, ...]

    def __str__(self) -> str:
        return " and ".join(map(str, self.parts))

    def half_planes(self, q: Array, dq: Array, ddq: Array) -> HalfPlanes:
        """Return the half-planes of all constraints (see ``PathConstraint``).

        Args:
            q: (M, n) configurations.
            dq: (M, n) dq/ds.
            ddq: (M, n) d2q/ds2.

        Returns:
            The half-planes that path acceleration and squared path velocity must stay in.
        """
        each = [part.half_planes(q, dq, ddq) for part in self.parts]
        return HalfPlanes(*(np.hstack(rows) for rows in zip(*((p.a, p.b, p.c) for p in each), strict=True)))

    def time_scale(self, q: Array, velocity: Array, acceleration: Array) -> Array:
        """Return the factor of time at which states of a motion keep all constraints (see there).

        Args:
            q: (M, n) configurations.
            velocity: (M, n) per s.
            acceleration: (M, n) per s^2.

        Returns:
            (M,) at least 1; inf if not even rest keeps them.
        """
        return np.asarray(np.max([part.time_scale(q, velocity, acceleration) for part in self.parts], axis=0))

    def broken_at_rest(self, q: Array) -> str:
        """Say which of the constraints are broken by rest.

        Args:
            q: (n,) configuration.

        Returns:
            The limits, with figures where there are any.
        """
        rest = np.zeros((1, len(q)))
        broken = (part for part in self.parts if not np.isfinite(part.time_scale(q[None], rest, rest)).all())
        return " and ".join(part.broken_at_rest(q) for part in broken)
