"""Mass properties of rigid bodies: what inverse dynamics and the physics engine need to know of a link."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.shapes import Body
from pickcli.geometry import Array

DENSITY = 1000.0  # kg/m^3, assumed for links without a mass, over the boxes around their shapes
LEAST_MASS = 1e-3  # kg; physics engines divide by masses
LEAST_SIZE = 0.005  # m; nor do they accept bodies without extent
ROUNDED = 1e-3  # share by which principal moments, as printed in a URDF, may break their inequality


@dataclass(frozen=True, eq=False)
class Inertial:
    """Mass properties of a rigid body.

    Attributes:
        mass: kg.
        centre: (3,) m, centre of mass in the body's frame.
        inertia: (3, 3) kg m^2 about the centre of mass, in the axes of the body's frame.
    """

    mass: float
    centre: Array
    inertia: Array

    def joined(self, other: Inertial) -> Inertial:
        """Return the mass properties of this body and one that is fixed to it, as a whole.

        Args:
            other: The other body, in the same frame.

        Returns:
            Both together.
        """
        mass = self.mass + other.mass
        centre = (self.mass * self.centre + other.mass * other.centre) / mass
        return Inertial(mass, centre, self._about(centre) + other._about(centre))

    def _about(self, point: Array) -> Array:
        """Return the inertia (3, 3) about a point (3,), by the parallel axis theorem."""
        arm = self.centre - point
        return np.asarray(self.inertia + self.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm)))


def is_possible(inertia: Array) -> bool:
    """Whether a matrix is the inertia of a body: no principal moment is larger than the other two together.

    Args:
        inertia: (3, 3) kg m^2, symmetric.

    Returns:
        False for zeros, too, which files state for what nobody measured.
    """
    least, middle, most = np.linalg.eigvalsh(inertia).tolist()
    return bool(least > 0.0 and most <= (least + middle) * (1.0 + ROUNDED))


def box_inertia(mass: float, bodies: Sequence[Body]) -> Array:
    """Compute the inertia of the box around a link's shapes, as if its mass were spread evenly over it.

    Args:
        mass: kg.
        bodies: The shapes, in the link frame.

    Returns:
        (3, 3) kg m^2 about its centre, in the axes of the link.
    """
    size = np.full(3, LEAST_SIZE)
    if bodies:
        p = np.array([body.T_parent_shape[:3, 3] for body in bodies])
        half = np.array([body.shape.reach(body.T_parent_shape[:3, :3]) for body in bodies])
        size = np.maximum(size, (p + half).max(axis=0) - (p - half).min(axis=0))
    squares = size**2
    return np.asarray(np.diag(mass * (squares.sum() - squares) / 12.0))


def assumed_inertial(bodies: Sequence[Body]) -> Inertial:
    """Return the mass properties that are assumed for a link of which the URDF states none.

    Args:
        bodies: The shapes of the link, in its frame.

    Returns:
        A body as heavy as water in the boxes around the shapes, around the origin of the link.
    """
    volume = sum(float(np.prod(body.shape.extents)) for body in bodies)
    mass = max(LEAST_MASS, DENSITY * volume)
    return Inertial(mass, np.zeros(3), box_inertia(mass, bodies))
