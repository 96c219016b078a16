"""Contacts between solids: which of them carry weight, and the forces that they can exert."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pickcli.geometry import Array, perpendiculars

# least vertical component of the normal of a contact that carries weight
CARRYING_NORMAL_Z = np.sin(np.radians(20.0))
STEEP_NORMAL_XY = np.sin(np.arctan(0.5))  # least horizontal component of the normal of a contact without hold
FRICTION = 0.2  # assumed coefficient; cardboard, plastic and cloth on board have 0.25 to 0.5
MOST_FORCE = 4.0  # weights; larger forces mean wedging, and wedges slip
BALANCED = 1e-9  # weights, or weights times size; rounding
UNBALANCED = 1e-6  # weights, or weights times size; tolerated residual


@dataclass(frozen=True, eq=False)
class SolidContact:
    """Two solids that are in contact, or may be within their pose uncertainty.

    Attributes:
        a: Id of the item.
        b: Id of the other item, or name of a body.
        gap: m, negative if they overlap.
        normal: (3,) unit vector in the world from a to b.
    """

    a: str
    b: str
    gap: float
    normal: Array

    @property
    def flipped(self) -> SolidContact:
        """The contact as seen from the other solid."""
        return SolidContact(self.b, self.a, self.gap, -self.normal)

    @property
    def carries(self) -> bool:
        """Whether b bears weight of a."""
        return bool(self.normal[2] <= -CARRYING_NORMAL_Z)

    @property
    def is_steep(self) -> bool:
        """Whether friction cannot hold an item there, so that something else must keep it from sliding."""
        return bool(np.hypot(self.normal[0], self.normal[1]) > STEEP_NORMAL_XY)


def bears(patch: Array, normal: Array, force: Array, point: Array) -> bool:
    """Whether a single contact resists a force: its line passes the patch inside the friction cone.

    Args:
        patch: (N, 3) corners of the contact; empty if the contact is uncertain.
        normal: (3,) unit contact normal, out of the bearing solid.
        force: (3,) world axes.
        point: (3,) on the line of the force.

    Returns:
        True if it does.
    """
    along, (u, v) = -float(force @ normal), perpendiculars(normal)
    if len(patch) == 0 or along <= 0.0 or abs(force @ u) + abs(force @ v) > FRICTION * along:
        return False
    corners = patch - (point + force * (float((point - patch[0]) @ normal) / along))
    angles = sorted(np.arctan2(corners @ v, corners @ u).tolist())
    return all(b - a < math.pi for a, b in pairwise([*angles, angles[0] + 2.0 * math.pi]))


def friction_cones(arms: Array, normal: Array, friction: float = FRICTION) -> Array:
    """Compute the wrenches of unit forces along the edges of friction cones.

    Args:
        arms: (N, 3) m, from the centre of an item to the contact points.
        normal: (3,) direction of the normal force on the item.
        friction: Coefficient of friction.

    Returns:
        (6, 4 N) wrenches about the centre.
    """
    u, v = perpendiculars(normal)
    forces = normal + friction * np.array([u, -u, v, -v])
    all_forces = np.tile(forces, (len(arms), 1))
    return np.concatenate([all_forces.T, np.cross(np.repeat(arms, 4, axis=0), all_forces).T])


def missing_to_balance(
    cones: Array, wrench: Array, size: float, limits: Sequence[tuple[int, float]]
) -> float:
    """Compute the part of a wrench that contact forces cannot balance, by a linear program.

    Args:
        cones: (6, K) wrenches of unit forces.
        wrench: (6,) in weights of the item, and weights times m.
        size: m, half the extent of the item.
        limits: For each body that presses only by its weight: the number of its cones, which come first in
            the order of ``limits``, and the largest sum of its forces in weights of the item. Other forces
            are unlimited.

    Returns:
        The least sum of unbalanced components in weights; moments are divided by the item's size.
    """
    from scipy.optimize import linprog

    unlimited = cones[:, sum(n for n, _ in limits) :]
    if unlimited.size and balance(unlimited, wrench, size)[1] <= BALANCED:  # quicker than the program
        return 0.0
    scale, n_cones = np.repeat([1.0, 1.0 / size], 3), cones.shape[1]
    ends = np.cumsum([n for n, _ in limits], dtype=int)
    is_of = np.zeros((len(limits), n_cones + 12))
    for row, (n, _), end in zip(is_of, limits, ends, strict=True):
        row[end - n : end] = 1.0
    found = linprog(
        np.concatenate([np.zeros(n_cones), np.ones(12)]),
        A_ub=is_of if limits else None,
        b_ub=[most for _, most in limits] if limits else None,
        A_eq=np.hstack([cones * scale[:, None], np.eye(6), -np.eye(6)]),
        b_eq=wrench * scale,
        method="highs-ds",
    )
    return float(found.fun)


def can_balance(cones: Array, wrench: Array, size: float) -> bool:
    """Whether contact forces up to MOST_FORCE can balance a wrench.

    Args:
        cones: (6, K) wrenches of unit forces.
        wrench: (6,) in weights of the item, and weights times m.
        size: m, half the extent of the item.

    Returns:
        True if they do.
    """
    forces, rest = balance(cones, wrench, size)
    return bool(rest <= UNBALANCED and forces.sum() <= MOST_FORCE)


def balance(cones: Array, wrench: Array, size: float) -> tuple[Array, float]:
    """Compute the contact forces that come nearest to balancing a wrench.

    Args:
        cones: (6, K) wrenches of unit forces.
        wrench: (6,) in weights of the item, and weights times m.
        size: m, half the extent of the item.

    Returns:
        (K,) forces in weights, and the norm of what is left unbalanced, moments as forces at the item's size.
    """
    from scipy.optimize import nnls

    scale = np.repeat([1.0, 1.0 / size], 3)
    forces, rest = nnls(cones * scale[:, None], wrench * scale)
    return forces, float(rest)
