"""Whether forces exist that keep a pile of rigid bodies at rest: static equilibrium as a linear program.

A pile may stand if forces at its contacts, within cones of friction, balance the weights of all bodies at
once (Mattikalli, Baraff and Khosla, Finding all stable orientations of assemblies with friction, 1996). Over
which area two bodies press on each other is not computed: both must reach the centre of pressure, so that is
a mean of points of the one and at the same time of points of the other. What is missing to the balance, the
least in all, tells who falls (elastic programming).

All is taken as it favours rest: friction as large as cardboard has on board, contacts wherever poses may be
off. So a pile without an equilibrium falls, and one with an equilibrium may fall all the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, perpendiculars
from pickcli.verification.separation import overlap, support

FRICTION = 0.3
ASKEW = np.radians(1.5)  # by which faces that lie on each other may be askew, besides errors of their poses
BREADTH = 0.5e-3  # m to every side of it that an edge or a corner bears
N_POINTS = 8  # of each body around a contact


@dataclass(frozen=True, eq=False)
class RigidBody:
    """A body of a pile, or one that stands firm. Its centre of mass is the centre of its shape.

    Attributes:
        name: Its name.
        shape: Its shape.
        T: (4, 4) its pose in the world.
        mass: kg; infinite of what stands firm.
        bound: m that any point of it may be from where its pose says.
    """

    name: str
    shape: Shape
    T: Array
    mass: float
    bound: float = 0.0

    @property
    def is_firm(self) -> bool:
        """Whether the body is firm, so that no force moves it."""
        return bool(np.isinf(self.mass))


@dataclass(frozen=True, eq=False)
class PileContact:
    """Two bodies that touch, or may.

    Attributes:
        a: The one.
        b: The other.
        normal: (3,) unit vector in the world from b to a.
        gap: m between them across it, negative where they overlap.
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
        """The contact as seen from the other of the two."""
        return PileContact(self.b, self.a, -self.normal, self.gap, self.points_b, self.points_a)

    @classmethod
    def across(cls, a: RigidBody, b: RigidBody, normal: Array, gap: float, askew: float) -> PileContact:
        """The contact of two bodies across a direction.

        Args:
            a: The one.
            b: The other.
            normal: (3,) unit vector in the world from b to a.
            gap: m between them across it.
            askew: rad by which errors of poses may turn one against the other.

        Returns:
            The contact.
        """
        tolerance = ASKEW + askew
        return cls(a, b, normal, gap, _outermost(a, -normal, tolerance), _outermost(b, normal, tolerance))

    @classmethod
    def between(cls, a: RigidBody, b: RigidBody, reach: float, askew: float) -> PileContact | None:
        """The contact of two bodies, if they are near enough.

        Args:
            a: The one.
            b: The other.
            reach: m that bodies which touch may be apart.
            askew: rad by which errors of poses may turn one against the other.

        Returns:
            The contact, None if they are farther apart.
        """
        depth, way = overlap(b.shape, b.T, a.shape, a.T)
        return cls.across(a, b, way, -depth, askew) if depth >= -reach else None


def _outermost(body: RigidBody, way: Array, tolerance: float) -> Array:
    """(K, 3) m, corners of what of a body is outermost in a direction and those beside it by a tolerance.

    Round it, where it is round, no direction beside it counts: a ball does not bear beside where it touches.
    """
    axis, turns = body.T[:3, 2], 2.0 * np.pi * np.arange(N_POINTS) / N_POINTS
    aside = np.column_stack([np.cos(turns), np.sin(turns)]) @ np.array(perpendiculars(way))
    turned = np.tan(tolerance) * aside
    if body.shape.kind is ShapeKind.SPHERE:
        turned = np.zeros_like(aside)
    elif body.shape.kind is ShapeKind.CYLINDER and np.linalg.norm(np.cross(way, axis)) > np.sin(tolerance):
        turned = np.outer(turned @ axis, axis)
    points = np.array([support(body.shape, body.T, way + turn) for turn in turned])
    return np.asarray(points + BREADTH * aside)


def missing_to_balance(
    bodies: Sequence[RigidBody], contacts: Sequence[PileContact], up: Array
) -> dict[str, float]:
    """What is missing to an equilibrium, the least in all.

    Args:
        bodies: Those that must be balanced.
        contacts: Between them, and with others, which stand firm.
        up: (3,) unit vector in the world against which weights act.

    Returns:
        By name: how much force and moment must be added, in weights of the body and in its weight times half
        its size.
    """
    program = _Program(bodies, np.tile(np.append(up, np.zeros(3)), len(bodies)))
    for contact in contacts:
        program.add(contact)
    return dict(zip((body.name for body in bodies), program.least_added().tolist(), strict=True))


class _Program:
    """Six rows for the balance of each body, three for the centre of pressure of each contact.

    bodies: those that must be balanced. borne: (6 N,) what contacts must exert on each, in weights
    """

    def __init__(self, bodies: Sequence[RigidBody], borne: Array) -> None:
        self._row = {body.name: 6 * k for k, body in enumerate(bodies)}
        self._borne, self._n_rows, self._n_columns = borne, len(borne), 0
        self._blocks: list[tuple[int, int, Array]] = []

    def add(self, contact: PileContact) -> None:
        """Unknown: forces along the edges of a's cones of friction, and weights of b's points."""
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
            moments = across @ (at - middle).T / BREADTH
            self._blocks.append((self._n_rows, column, sign * np.vstack([np.ones(len(at)), moments])))
        self._n_rows += 3
        self._n_columns = second + len(contact.points_b)

    def least_added(self) -> Array:
        """(N,) what must be added to balance each body, where forces are chosen that leave the least."""
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
    """Half of a body's longest side, m."""
    return float(body.shape.extents.max()) / 2.0
