"""The wrench on the cup as a path constraint: an inscribed polytope of what the cup bears.

At one place of a path the wrench lies in a plane, a u + b x + c (``HeldBody.path_wrench``), and what the cup
bears cuts a convex set out of it. That set is what has to be inscribed, not the limit surface, for which
hundreds of faces would do no better. The corners of its polygon lie where evenly spaced directions, seen from
the wrench at rest, meet the limit: whatever the item's weight leaves of the limits is used equally well.
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
AT_REST = 1e-3  # share of the limits that polygons leave at least, where the weight takes up nearly all
HALVINGS = 30  # of the share of the motion's own wrench that a state keeps its limits with
VANISHED = 1e-9  # share of the limits per unit of path: nothing

Plane = tuple[Array, Array, Array]
"""a, b and c (M, k) of a u + b x + c."""


@dataclass(frozen=True, eq=False)
class WrenchLimit:
    """A body held in the cup, or between pads, while the arm moves.

    Attributes:
        arm: Moves the tool.
        tool_state: State of the tool.
        body: What it holds.
        limits: What the cup bears at full vacuum, or the pads.
        share: Of the limits that may be used: vacuum under the cup over full vacuum, and any margin.
    """

    arm: Arm
    tool_state: ToolState
    body: HeldBody
    limits: GripLimits
    share: float

    def __str__(self) -> str:
        return f"{self.share:.2f} of what {self.limits.bearer}"

    def half_planes(self, q: Array, dq: Array, ddq: Array) -> HalfPlanes:
        """Polygons inscribed in the limits of the wrench (see ``PathConstraint``).

        Args:
            q: (M, n) configurations.
            dq: (M, n) dq/ds.
            ddq: (M, n) d2q/ds2.

        Returns:
            The half-planes that keep the wrench inside what the cup bears.
        """
        plane = self._along_axis(self.body.path_wrench(self.arm.tip_motion(q, dq, ddq, self.tool_state)))
        inside = (_inscribed(*self._slip(plane)), *(_inscribed(*of) for of in self._lip(plane)))
        return HalfPlanes(*(np.concatenate(columns, axis=1) for columns in zip(*inside, strict=True)))

    def stretch(self, q: Array, velocity: Array, acceleration: Array) -> Array:
        """Factor of time at which the wrench keeps the limits themselves (see ``PathConstraint``).

        The wrench beyond that at rest falls with the square of time. The states that keep the limits with a
        share of it are an interval from 0, as the limits are convex.

        Args:
            q: (M, n) configurations.
            velocity: (M, n) per s.
            acceleration: (M, n) per s^2.

        Returns:
            (M,) at least 1; inf where not even rest keeps the limits.
        """
        motion = self.arm.tip_motion(q, velocity, acceleration, self.tool_state)
        moving = self.body.wrench(motion)
        factor = np.ones(len(q))
        over = np.flatnonzero(self.limits.ratio(moving, self.share) > 1.0)
        if len(over) == 0:
            return factor
        resting = self.body.wrench(motion.at_rest())[over]
        low, high = np.zeros(len(over)), np.ones(len(over))
        for _ in range(HALVINGS):
            share = (low + high) / 2
            wrench = resting + share[:, None] * (moving[over] - resting)
            holds = self.limits.ratio(wrench, self.share) <= 1.0
            low, high = np.where(holds, share, low), np.where(holds, high, share)
        with np.errstate(divide="ignore"):
            factor[over] = 1.0 / np.sqrt(low)
        return factor

    def _along_axis(self, plane: Plane) -> Plane:
        """Wrenches in axes whose last one is that of the hold."""
        a, b, c = plane
        return self.limits.along_axis(a), self.limits.along_axis(b), self.limits.along_axis(c)

    def _slip(self, plane: Plane) -> tuple[Plane, Plane]:
        """Friction, (|shear| / max_shear)^2 + (|twist| / max_twist)^2 <= share^2, as of ``_inscribed``.

        Scaled by the limits this is the unit ball, which the plane cuts in a disc.
        """
        scale = np.array([self.limits.max_shear, self.limits.max_shear, self.limits.max_twist]) * self.share
        a, b, c = (w[:, [0, 1, 5]] / scale for w in plane)
        e1 = _direction(a, b, np.eye(3)[:1])
        e2 = _across(e1, b)
        off = c - _dot(c, e1) * e1 - _dot(c, e2) * e2
        radius = np.sqrt(np.maximum(1.0 - _dot(off, off), AT_REST**2))
        a, b, c = (np.concatenate([_dot(v, e1), _dot(v, e2)], axis=1) for v in (a, b, c))
        return (a, b, c), _constant(radius)

    def _lip(self, plane: Plane) -> tuple[tuple[Plane, Plane], ...]:
        """The lip, max(0, pull) / max_pull + |bending| / max_moment <= share, with pull and without."""
        a, b, c = (w[:, 3:5] / self.limits.max_moment / self.share for w in plane)
        by_u, by_x, at_rest = (w[:, 2:3] / self.limits.max_pull / self.share for w in plane)
        room = np.maximum(1.0 + at_rest, AT_REST)  # fz, which is the pull with its sign turned
        if self.limits.bears_push:
            return ((a, b, c), (by_u, by_x, room)), ((a, b, c), _constant(np.ones_like(room)))
        pushed = np.maximum(1.0 - at_rest, AT_REST)
        return ((a, b, c), (by_u, by_x, room)), ((a, b, c), (-by_u, -by_x, pushed))


def _inscribed(vector: Plane, radius: Plane) -> Plane:
    """Half-planes a u + b x <= c of a polygon inside |vector| <= radius, both linear in u and x.

    Args:
        vector: (M, 2) each.
        radius: (M, 1) each; positive at rest.

    Returns:
        (M, N_EDGES) each, c positive. Along u alone from rest, with a constant radius, it is exact.
    """
    rest = vector[2] / radius[2]
    rest = (
        rest * np.minimum(1.0, (1.0 - AT_REST) / np.maximum(np.linalg.norm(rest, axis=1), AT_REST))[:, None]
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
    """A radius (M, 1) that does not depend on u and x."""
    zero = np.zeros_like(radius)
    return zero, zero, radius


def _dot(v: Array, e: Array) -> Array:
    """(M, 1) scalar products of two arrays (M, k)."""
    return np.asarray((v * e).sum(axis=1, keepdims=True))


def _direction(*candidates: Array) -> Array:
    """Unit vectors (M, k) along the first of the candidates (M, k) that does not vanish."""
    out = np.zeros_like(candidates[0])
    for vector in reversed(candidates):
        length = np.linalg.norm(vector, axis=1, keepdims=True)
        out = np.where(length > VANISHED, vector / np.maximum(length, VANISHED), out)
    return out


def _across(e: Array, v: Array) -> Array:
    """Unit vectors (M, 3) across e, in the plane of e and v where these are not one line."""
    flattest = np.eye(3)[np.abs(e).argmin(axis=1)]
    found = _direction(v - _dot(v, e) * e, np.cross(e, flattest))
    return _direction(found - _dot(found, e) * e)
