"""Contacts between solids: which of them carry weight, and what forces they can exert."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.geometry import Array, perpendiculars

CARRIES = np.sin(np.radians(20.0))  # vertical part of a contact's normal from which on it carries weight
STEEP = np.sin(
    np.arctan(0.5)
)  # level part of a contact's normal from which on no friction holds what is on it
FRICTION = 0.2  # that is counted on; cardboard, plastic and cloth on board have 0.25 to 0.5
MOST_FORCE = 4.0  # weights: what needs more is wedged, and wedges slip
UNBALANCED = 1e-6  # weights, or weights times size, that may be left over


@dataclass(frozen=True, eq=False)
class SolidContact:
    """Two solids that touch, or may: their poses are uncertain.

    Attributes:
        a: Id of the item.
        b: Id of the other item, or name of the pod's body.
        gap: m, negative where they overlap.
        normal: (3,) unit vector in the world from a to b.
    """

    a: str
    b: str
    gap: float
    normal: Array

    @property
    def flipped(self) -> SolidContact:
        """The contact as seen from the other of the two."""
        return SolidContact(self.b, self.a, self.gap, -self.normal)

    @property
    def carries(self) -> bool:
        """Whether b bears weight of a."""
        return bool(self.normal[2] <= -CARRIES)

    @property
    def is_steep(self) -> bool:
        """Whether what lies there must be held by something else too, and so holds what it lies on."""
        return bool(np.hypot(self.normal[0], self.normal[1]) > STEEP)


def bears(patch: Array, normal: Array, force: Array, point: Array) -> bool:
    """Whether a contact by itself holds against a force: its line leads steeply enough through the patch.

    Args:
        patch: (N, 3) corners of where the contact is; none where it may as well be off aside.
        normal: (3,) unit vector across the contact, out of what bears.
        force: (3,) world axes.
        point: (3,) on the line of the force.

    Returns:
        True if it does.
    """
    along, across = -float(force @ normal), np.column_stack(perpendiculars(normal))
    if len(patch) == 0 or along <= 0.0 or float(np.abs(force @ across).sum()) > FRICTION * along:
        return False
    through = point + force * (float((point - patch[0]) @ normal) / along)
    x, y = ((patch - through) @ across).T
    angles = np.sort(np.arctan2(y, x))
    gaps_between = np.diff(angles, append=angles[0] + 2.0 * np.pi)
    return bool(gaps_between.max() < np.pi)


def friction_cones(arms: Array, normal: Array) -> Array:
    """Wrenches of unit forces on the edges of friction cones.

    Args:
        arms: (N, 3) m, from the centre of an item to the points at which it is pushed.
        normal: (3,) direction in which they push.

    Returns:
        (6, 4 N) about the centre.
    """
    u, v = perpendiculars(normal)
    forces = normal + FRICTION * np.array([u, -u, v, -v])
    all_forces = np.tile(forces, (len(arms), 1))
    return np.concatenate([all_forces.T, np.cross(np.repeat(arms, 4, axis=0), all_forces).T])


def missing_to_balance(
    cones: Array, wrench: Array, size: float, limits: Sequence[tuple[int, float]]
) -> float:
    """How much of a wrench contact forces cannot make up, by a linear program.

    Args:
        cones: (6, K) wrenches of unit forces.
        wrench: (6,) in weights of the item, and weights times m.
        size: m, half the extent of the item.
        limits: Of what presses by its weight alone: how many of the cones, from the first on, are its, and
            how many weights of the item they may come to in all. The others push as hard as they have to.

    Returns:
        Weights, the least that there may be; moments count as forces at the item's size.
    """
    from scipy.optimize import linprog

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
    """Whether contact forces that are not too large make up a wrench.

    Args:
        cones: (6, K) wrenches of unit forces.
        wrench: (6,) in weights of the item, and weights times m.
        size: m, half the extent of the item.

    Returns:
        True if they do.
    """
    from scipy.optimize import nnls

    scale = np.repeat([1.0, 1.0 / size], 3)
    forces, rest = nnls(cones * scale[:, None], wrench * scale)
    return bool(rest <= UNBALANCED and forces.sum() <= MOST_FORCE)
