"""The wrench on the cup as a path constraint: an inscribed polytope of what the cup bears.

At one place of a path the wrench lies in a plane, a u + b x + c (``HeldBody.path_wrench``), and what the cup
bears cuts a convex set out of it. That set is what has to be inscribed, not the limit surface: a polygon of
16 edges gives away 1.9 % at most, where a polytope of the surface itself would need hundreds of faces.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.cup_limits import CupLimits
from pickcli.cell.robot import PivotState
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.kinematics.held_body import HeldBody
from pickcli.timing.path_constraint import HalfPlanes

EDGES_OF_SLIP = 16  # of the polygon inscribed in the section of the friction's ellipsoid
EDGES_OF_LIP = 16  # of the polygon inscribed in the circle of bending
AT_REST = 1e-3  # share of the limits that half-planes leave where rest takes up all of them
HALVINGS = 30  # of the share of the motion's own wrench that a state keeps its limits with

VANISHED = 1e-9  # share of the limits per unit of path: nothing

Plane = tuple[Array, Array, Array]
"""a, b and c (M, k) of a u + b x + c."""


@dataclass(frozen=True, eq=False)
class WrenchLimit:
    """A body held in the cup while the arm moves.

    Attributes:
        arm: Moves the cup.
        pivot: State of the cup.
        body: What it holds.
        limits: What the cup bears at full vacuum.
        share: Of the limits that may be used: vacuum under the cup over full vacuum, and any margin.
    """

    arm: Arm
    pivot: PivotState
    body: HeldBody
    limits: CupLimits
    share: float

    def __str__(self) -> str:
        return f"{self.share:.2f} of what the cup bears"

    def half_planes(self, q: Array, dq: Array, ddq: Array) -> HalfPlanes:
        """Polygons inscribed in the wrench's limits; see ``PathConstraint``."""
        plane = self.body.path_wrench(self.arm.tip_motion(q, dq, ddq, self.pivot))
        slip, lip = self._slip(plane), self._lip(plane)
        a, b, c = (np.concatenate(columns, axis=1) for columns in zip(slip, lip, strict=True))
        return HalfPlanes(a, b, np.maximum(c, AT_REST))

    def stretch(self, q: Array, velocity: Array, acceleration: Array) -> Array:
        """By the limits themselves; see ``PathConstraint``.

        The wrench beyond that at rest falls with the square of time. The states that keep the limits with
        a share of it are an interval from 0, as the limits are convex.
        """
        motion = self.arm.tip_motion(q, velocity, acceleration, self.pivot)
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

    def _slip(self, plane: Plane) -> Plane:
        """Half-planes of friction, (|shear| / max_shear)^2 + (|twist| / max_twist)^2 <= share^2.

        Scaled by the limits this is the unit ball, which a plane cuts in a disc. The polygon has one of its
        corners where u alone leads to, so that a straight line is limited exactly.
        """
        scale = np.array([self.limits.max_shear, self.limits.max_shear, self.limits.max_twist]) * self.share
        a, b, c = (w[:, [0, 1, 5]] / scale for w in plane)
        e1 = _direction(a, b, np.array([[1.0, 0.0, 0.0]]))
        e2 = _across(e1, b, c)
        off = c - _dot(c, e1) * e1 - _dot(c, e2) * e2
        radius = np.sqrt(np.maximum(1.0 - _dot(off, off), 0.0))
        cos, sin = _normals(EDGES_OF_SLIP)
        of_a, of_b, of_c = (_dot(v, e1) * cos + _dot(v, e2) * sin for v in (a, b, c))
        return of_a, of_b, radius * np.cos(np.pi / EDGES_OF_SLIP) - of_c

    def _lip(self, plane: Plane) -> Plane:
        """Half-planes of the lip, max(0, pull) / max_pull + |bending| / max_moment <= share.

        Once with pull and once without, each a polygon in the plane of bending with a corner towards where
        u leads to.
        """
        bending = [w[:, 3:5] / self.limits.max_moment / self.share for w in plane]
        pull = [-w[:, 2:3] / self.limits.max_pull / self.share for w in plane]
        e1 = _direction(bending[0], bending[2], np.array([[1.0, 0.0]]))
        e2 = np.stack([-e1[:, 1], e1[:, 0]], axis=1)
        cos, sin = _normals(EDGES_OF_LIP)
        inner = np.cos(np.pi / EDGES_OF_LIP)
        of_a, of_b, of_c = ((_dot(v, e1) * cos + _dot(v, e2) * sin) / inner for v in bending)
        a = np.concatenate([of_a, of_a + pull[0]], axis=1)
        b = np.concatenate([of_b, of_b + pull[1]], axis=1)
        return a, b, 1.0 - np.concatenate([of_c, of_c + pull[2]], axis=1)


def _normals(n_edges: int) -> tuple[Array, Array]:
    """Cosines and sines (n_edges,) of the normals of a regular polygon with a corner at angle 0."""
    angle = (np.arange(n_edges) + 0.5) * 2.0 * np.pi / n_edges
    return np.cos(angle), np.sin(angle)


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


def _across(e: Array, b: Array, c: Array) -> Array:
    """Unit vectors (M, 3) across e in the plane of e and b; where these are one line, across c too.

    Then nothing moves across e, and the section is cut where c puts it.
    """
    flattest = np.eye(3)[np.abs(e).argmin(axis=1)]
    found = _direction(np.cross(e, np.cross(b, e)), np.cross(e, c), np.cross(e, flattest))
    return _direction(found - _dot(found, e) * e)
