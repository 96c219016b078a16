"""Decide whether contact forces exist that keep a pile of rigid bodies at rest, by a linear program.

A pile may stand if forces at its contacts, within friction cones, balance the weights of all bodies at once
(Mattikalli, Baraff and Khosla, Finding all stable orientations of assemblies with friction, 1996). The area
over which two bodies press on each other is not computed: the centre of pressure must be a mean of points of
the one and also a mean of points of the other. The minimal force that is missing for balance shows which
bodies fall (elastic programming).

All assumptions favour rest: friction is as large as between cardboard boxes, and contacts are assumed
where pose errors allow them. So a pile without an equilibrium falls; one with an equilibrium may still
fall.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, perpendiculars
from pickcli.verification.separation import overlap, separation, support

FRICTION = 0.3
# angle that faces lying on each other may enclose, besides errors of their poses
FACE_ANGLE_TOLERANCE = np.radians(1.5)
CONTACT_HALF_WIDTH = 0.5e-3  # m to each side of an edge or a corner that still bears
N_CONTACT_POINTS = 8  # of each body around a contact


@dataclass(frozen=True, eq=False)
class RigidBody:
    """A body of a pile, or a fixed one. Its centre of mass is the centre of its shape.

    Attributes:
        name: Its name.
        shape: Its shape.
        T: (4, 4) its pose in the world.
        mass: kg; infinite if the body is fixed.
        bound: m, error of the position of any point of it, at most.
        angle: rad, error of its orientation, at most.
    """

    name: str
    shape: Shape
    T: Array
    mass: float
    bound: float = 0.0
    angle: float = 0.0

    @property
    def is_firm(self) -> bool:
        """Whether the body is fixed, so that no force moves it."""
        return bool(np.isinf(self.mass))


@dataclass(frozen=True, eq=False)
class PileContact:
    """Two bodies that touch, or may touch.

    Attributes:
        a: One body.
        b: The other body.
        normal: (3,) unit vector in the world from b to a.
        gap: m between them along the normal, negative if they overlap.
        points_a: (K, 3) m, corners of the outermost part of a towards b.
        points_b: (M, 3) m, corners of the outermost part of b towards a.
    """

    a: RigidBody
    b: RigidBody
    normal: Array
    gap: float
    points_a: Array
    points_b: Array

    @property
    def flipped(self) -> PileContact:
        """The contact with both bodies exchanged."""
        return PileContact(self.b, self.a, -self.normal, self.gap, self.points_b, self.points_a)

    @classmethod
    def across(cls, a: RigidBody, b: RigidBody, normal: Array, gap: float, askew: float) -> PileContact:
        """Build the contact of two bodies along a given direction.

        Args:
            a: One body.
            b: The other body.
            normal: (3,) unit vector in the world from b to a.
            gap: m between them along it.
            askew: rad by which pose errors may turn one against the other.

        Returns:
            The contact.
        """
        tolerance = FACE_ANGLE_TOLERANCE + askew
        return cls(a, b, normal, gap, _outermost(a, -normal, tolerance), _outermost(b, normal, tolerance))

    @classmethod
    def between(cls, a: RigidBody, b: RigidBody, reach: float, askew: float) -> PileContact | None:
        """Build the contact of two bodies, if they are near enough.

        Args:
            a: One body.
            b: The other body.
            reach: m, largest gap of bodies that count as touching.
            askew: rad by which pose errors may turn one against the other.

        Returns:
            The contact, None if they are farther apart.
        """
        depth, way = overlap(b.shape, b.T, a.shape, a.T)
        # Across edges and corners the gaps between faces are less than the distance.
        if depth < -reach or (depth < 0.0 and separation(a.shape, a.T, b.shape, b.T) > reach):
            return None
        return cls.across(a, b, way, -depth, askew)


def _outermost(body: RigidBody, way: Array, tolerance: float) -> Array:
    """Return (K, 3) m: support points of a body along directions within a tolerance of a given one.

    For round sides only the direction itself counts: a ball bears only at the point of contact.
    """
    axis, turns = body.T[:3, 2], 2.0 * np.pi * np.arange(N_CONTACT_POINTS) / N_CONTACT_POINTS
    aside = np.column_stack([np.cos(turns), np.sin(turns)]) @ np.array(perpendiculars(way))
    turned = np.tan(tolerance) * aside
    if body.shape.kind is ShapeKind.SPHERE:
        turned = np.zeros_like(aside)
    elif body.shape.kind is ShapeKind.CYLINDER and np.linalg.norm(np.cross(way, axis)) > np.sin(tolerance):
        turned = np.outer(turned @ axis, axis)
    points = np.array([support(body.shape, body.T, way + turn) for turn in turned])
    return np.asarray(points + CONTACT_HALF_WIDTH * aside)


def missing_to_balance(
    bodies: Sequence[RigidBody], contacts: Sequence[PileContact], up: Array
) -> dict[str, float]:
    """Return the least force and moment that are missing for an equilibrium.

    Args:
        bodies: Bodies that must be balanced.
        contacts: Contacts between them and with other bodies, which count as fixed.
        up: (3,) unit vector in the world, opposite to gravity.

    Returns:
        By name: the force and moment that must be added, in units of the body's weight and of its weight
        times half its size.
    """
    program = _Program(bodies, np.tile(np.append(up, np.zeros(3)), len(bodies)))
    for contact in contacts:
        program.add(contact)
    return dict(zip((body.name for body in bodies), program.least_added().tolist(), strict=True))


class _Program:
    """The linear program: six rows for each body's balance, three for each contact's centre of pressure.

    bodies: bodies that must be balanced. borne: (6 N,) wrench that contacts must exert on each, in weights
    """

    def __init__(self, bodies: Sequence[RigidBody], borne: Array) -> None:
        self._row = {body.name: 6 * k for k, body in enumerate(bodies)}
        self._borne, self._n_rows, self._n_columns = borne, len(borne), 0
        self._blocks: list[tuple[int, int, Array]] = []

    def add(self, contact: PileContact) -> None:
        """Add a contact's unknowns: forces along the edges of a's friction cones, weights of b's points."""
        u, v = perpendiculars(contact.normal)
        edges = contact.normal + FRICTION * np.array([u, -u, v, -v])
        points, forces = np.repeat(contact.points_a, 4, axis=0), np.tile(edges, (len(contact.points_a), 1))
        first, second = self._n_columns, self._n_columns + len(points)
        for body, sign in ((contact.a, 1.0), (contact.b, -1.0)):
            if body.name in self._row:
                wrenches = np.hstack([forces, np.cross(points - body.T[:3, 3], forces) / _size(body)])
                self._blocks.append((self._row[body.name], first, sign / body.mass * wrenches.T))
        across, middle = np.array([u, v]), contact.points_b.mean(axis=0)
        for column, at, sign in ((first, points, 1.0), (second, contact.points_b, -1.0)):
            moments = across @ (at - middle).T / CONTACT_HALF_WIDTH
            self._blocks.append((self._n_rows, column, sign * np.vstack([np.ones(len(at)), moments])))
        self._n_rows += 3
        self._n_columns = second + len(contact.points_b)

    def least_added(self) -> Array:
        """Return (N,) the least force and moment that must be added to balance each body."""
        from scipy.optimize import linprog

        n, m = len(self._borne), self._n_columns
        equal = np.zeros((self._n_rows, m + 2 * n))
        for row, column, block in self._blocks:
            equal[row : row + block.shape[0], column : column + block.shape[1]] = block
        equal[:n, m : m + n], equal[:n, m + n :] = np.eye(n), -np.eye(n)
        found = linprog(
            np.concatenate([np.zeros(m), np.ones(2 * n)]),
            A_eq=equal,
            b_eq=np.concatenate([self._borne, np.zeros(self._n_rows - n)]),
            bounds=(0.0, None),
            method="highs-ds",
        )
        return np.asarray(found.x[m:].reshape(2, -1, 6).sum(axis=(0, 2)))


def _size(body: RigidBody) -> float:
    """Return half of a body's longest side, m."""
    return float(body.shape.extents.max()) / 2.0
