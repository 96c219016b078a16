"""Constraints on a timed path beyond those of its joints: second-order ones, in general position.

Along a path q(s) whatever is linear in accelerations and in products of velocities, as forces are, is

    a(s) u + b(s) x + c(s),    u = d2s/dt2,    x = (ds/dt)^2,

and a convex set that it must stay in is a convex set in the plane of (u, x): the second-order constraints
of Pham and Pham, "A New Approach to Time-Optimal Path Parameterization Based on Reachability Analysis",
IEEE T-RO 34(3), 2018, section II.B. What rests must be allowed: then the origin is in each set.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class HalfPlanes:
    """What a constraint leaves at M places of a path: a u + b x <= c.

    Attributes:
        a: (M, R) by path acceleration u, 1/s^2 for a path in joint units.
        b: (M, R) by squared path speed x.
        c: (M, R) without a unit, positive: rest is inside every half-plane.
    """

    a: Array
    b: Array
    c: Array


class PathConstraint(Protocol):
    """Something that limits how fast a path may be followed."""

    def half_planes(self, q: Array, dq: Array, ddq: Array) -> HalfPlanes:
        """The constraint at M places of a path, or something inside it.

        Args:
            q: (M, n) configurations.
            dq: (M, n) dq/ds.
            ddq: (M, n) d2q/ds2.

        Returns:
            The half-planes that path acceleration and squared path velocity must stay in.
        """
        ...

    def stretch(self, q: Array, velocity: Array, acceleration: Array) -> Array:
        """The factor of time at which states of a motion keep the constraint itself.

        Args:
            q: (M, n) configurations.
            velocity: (M, n) per s.
            acceleration: (M, n) per s^2.

        Returns:
            (M,) at least 1; inf where not even rest keeps it.
        """
        ...
