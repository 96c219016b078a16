"""The wrench on the cup as a path constraint: polygons inscribed in what the cup bears.

At one place of a path the wrench lies in a plane, a u + b x + c (``HeldBody.path_wrench``), and the limits of
the cup cut a convex set out of it. The polygon is inscribed in that set, not in the whole limit surface, for
which hundreds of faces would be no better. Its corners are where evenly spaced directions, starting from the
wrench at rest, meet the limit, so the capacity that the item's weight leaves is used equally well in all
directions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.tool import ToolState
from pickcli.cell.tools.grip_model import GripLimits
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.kinematics.held_body import HeldBody
from pickcli.timing.path_constraint import HalfPlanes

N_EDGES = 16  # of each polygon
MIN_SHARE = 1e-3  # share of the limits that polygons leave at least, if the weight takes up nearly all
N_BISECTIONS = 30  # bisections of the share of the motion's wrench at which a state keeps its limits
VANISHED = 1e-9  # share of the limits per unit of path that counts as 0

Plane = tuple[Array, Array, Array]
"""a, b and c (M, k) of a u + b x + c."""


@dataclass(frozen=True, eq=False)
class WrenchLimit:
    """Limit of the wrench on a body held in the cup, or between pads, while the arm moves.

    Attributes:
        arm: Kinematics of the arm that moves the tool.
        tool_state: State of the tool.
        body: The held body.
        limits: Limits of the cup at full vacuum, or of the pads.
        share: Usable share of the limits: vacuum under the cup over full vacuum, and any margin.
    """

    arm: Arm
    tool_state: ToolState
    body: HeldBody
    limits: GripLimits
    share: float

    def __str__(self) -> str:
        return f"{self.share:.2f} of what {self.limits.bearer}"

    def broken_at_rest(self, q: Array) -> str:
        """Say what is broken by rest (see ``PathConstraint``).

        Args:
            q: (n,) configuration.

        Returns:
            The limit.
        """
        return str(self)

    def half_planes(self, q: Array, dq: Array, ddq: Array) -> HalfPlanes:
        """Compute polygons inscribed in the limits of the wrench (see ``PathConstraint``).

        Args:
            q: (M, n) configurations.
            dq: (M, n) dq/ds.
            ddq: (M, n) d2q/ds2.

        Returns:
            The half-planes that keep the wrench within the limits.
        """
        plane = self._along_axis(self.body.path_wrench(self.arm.tip_motion(q, dq, ddq, self.tool_state)))
        inside = (_inscribed(*self._slip(plane)), *(_inscribed(*of) for of in self._peel(plane)))
        return HalfPlanes(*(np.concatenate(columns, axis=1) for columns in zip(*inside, strict=True)))

    def time_scale(self, q: Array, velocity: Array, acceleration: Array) -> Array:
        """Return the factor of time at which the wrench keeps the exact limits (see ``PathConstraint``).

        The wrench in excess of that at rest falls with the square of time. The shares of it that keep the
        limits form an interval from 0, because the limits are convex.

        Args:
            q: (M, n) configurations.
            velocity: (M, n) per s.
            acceleration: (M, n) per s^2.

        Returns:
            (M,) at least 1; inf if not even rest keeps the limits.
        """
        motion = self.arm.tip_motion(q, velocity, acceleration, self.tool_state)
        moving = self.body.wrench(motion)
        factor = np.ones(len(q))
        over = np.flatnonzero(self.limits.ratio(moving, self.share) > 1.0)
        if len(over) == 0:
            return factor
        resting = self.body.wrench(motion.at_rest())[over]
        low, high = np.zeros(len(over)), np.ones(len(over))
        for _ in range(N_BISECTIONS):
            share = (low + high) / 2
            wrench = resting + share[:, None] * (moving[over] - resting)
            holds = self.limits.ratio(wrench, self.share) <= 1.0
            low, high = np.where(holds, share, low), np.where(holds, high, share)
        with np.errstate(divide="ignore"):
            factor[over] = 1.0 / np.sqrt(low)
        return factor

    def _along_axis(self, plane: Plane) -> Plane:
        """Rotate wrenches to axes of which the last is that of the hold."""
        a, b, c = plane
        return self.limits.along_axis(a), self.limits.along_axis(b), self.limits.along_axis(c)

    def _slip(self, plane: Plane) -> tuple[Plane, Plane]:
        """Return friction, (|shear| / max_shear)^2 + (|twist| / max_twist)^2 <= share^2, for ``_inscribed``.

        Scaled by the limits this is the unit ball, whose intersection with the plane is a disc.
        """
        scale = np.array([self.limits.max_shear, self.limits.max_shear, self.limits.max_twist]) * self.share
        a, b, c = (w[:, [0, 1, 5]] / scale for w in plane)
        e1 = _direction(a, b, np.eye(3)[:1])
        e2 = _across(e1, b)
        off = c - _dot(c, e1) * e1 - _dot(c, e2) * e2
        radius = np.sqrt(np.maximum(1.0 - _dot(off, off), MIN_SHARE**2))
        a, b, c = (np.concatenate([_dot(v, e1), _dot(v, e2)], axis=1) for v in (a, b, c))
        return (a, b, c), _constant(radius)

    def _peel(self, plane: Plane) -> tuple[tuple[Plane, Plane], ...]:
        """Return peeling, max(0, pull) / max_pull + |bending| / max_moment <= share, for pull and without."""
        a, b, c = (w[:, 3:5] / self.limits.max_moment / self.share for w in plane)
        by_u, by_x, at_rest = (w[:, 2:3] / self.limits.max_pull / self.share for w in plane)
        pull_left = np.maximum(1.0 + at_rest, MIN_SHARE)  # fz, which is minus the pull
        if self.limits.bears_compression:
            return ((a, b, c), (by_u, by_x, pull_left)), ((a, b, c), _constant(np.ones_like(pull_left)))
        push_left = np.maximum(1.0 - at_rest, MIN_SHARE)
        return ((a, b, c), (by_u, by_x, pull_left)), ((a, b, c), (-by_u, -by_x, push_left))


def _inscribed(vector: Plane, radius: Plane) -> Plane:
    """Return half-planes a u + b x <= c of a polygon inside |vector| <= radius, both linear in u and x.

    Args:
        vector: (M, 2) each.
        radius: (M, 1) each; positive at rest.

    Returns:
        (M, N_EDGES) each, c positive. Exact along u from rest, for a constant radius.
    """
    rest = vector[2] / radius[2]
    rest = (
        rest
        * np.minimum(1.0, (1.0 - MIN_SHARE) / np.maximum(np.linalg.norm(rest, axis=1), MIN_SHARE))[:, None]
    )
    along = _direction(vector[0], vector[1], np.eye(2)[:1])
    angle = np.arange(N_EDGES) * 2.0 * np.pi / N_EDGES
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    rays = np.cos(angle)[:, None] * along[:, None] + np.sin(angle)[:, None] * across[:, None]  # (M, K, 2)
    towards = (rays @ rest[:, :, None])[:, :, 0]
    reach = np.sqrt(towards**2 + 1.0 - _dot(rest, rest)) - towards
    corners = rest[:, None] + reach[:, :, None] * rays  # on the unit circle
    middles = corners + np.roll(corners, -1, axis=1)
    normals = middles / np.linalg.norm(middles, axis=2, keepdims=True)
    distance = (normals * corners).sum(axis=2)
    a, b = (
        (normals @ v[:, :, None])[:, :, 0] - distance * r for v, r in zip(vector[:2], radius[:2], strict=True)
    )
    return a, b, radius[2] * (distance - (normals @ rest[:, :, None])[:, :, 0])


def _constant(radius: Array) -> Plane:
    """Return a radius (M, 1) that does not depend on u and x."""
    zero = np.zeros_like(radius)
    return zero, zero, radius


def _dot(v: Array, e: Array) -> Array:
    """Return (M, 1) scalar products of two arrays (M, k)."""
    return np.asarray((v * e).sum(axis=1, keepdims=True))


def _direction(*candidates: Array) -> Array:
    """Return unit vectors (M, k) along the first of the candidates (M, k) that does not vanish."""
    out = np.zeros_like(candidates[0])
    for vector in reversed(candidates):
        length = np.linalg.norm(vector, axis=1, keepdims=True)
        out = np.where(length > VANISHED, vector / np.maximum(length, VANISHED), out)
    return out


def _across(e: Array, v: Array) -> Array:
    """Return unit vectors (M, 3) across e, in the plane of e and v if these are not collinear."""
    flattest = np.eye(3)[np.abs(e).argmin(axis=1)]
    found = _direction(v - _dot(v, e) * e, np.cross(e, flattest))
    return _direction(found - _dot(found, e) * e)
