"""Contact area of two pads with an item, and the load limits there.

Flat faces touch the whole pad, round ones a strip whose width follows from the rubber's compliance. Computed
from the actual poses in the simulated world, not from the planned ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.tools.gripper import ParallelGripper
from pickcli.cell.tools.pinch_limits import PinchLimits
from pickcli.geometry import Array, transform_points

N_POINTS = 15  # sample points along each side of a pad
PAD_COMPRESSION = 3e-4  # m, compliance of a pad: a low estimate


@dataclass(frozen=True, eq=False)
class PadStiffness:
    """Stiffness of both pads about the middle between them. Estimated: see docs/simulation.md.

    Attributes:
        normal: N/m along the closing direction.
        shear: N/m along the pads.
        bend: Nm/rad about the axes perpendicular to the closing direction.
        twist: Nm/rad about the closing direction.
        relaxation: s, damping over stiffness.
    """

    normal: float = 5e5
    shear: float = 2e5
    bend: float = 50.0
    twist: float = 15.0
    relaxation: float = 3e-3

    @property
    def matrix(self) -> Array:
        """(6, 6) for (x, y, z, rotation vector) in the tool frame, y along the closing direction."""
        return np.diag([self.shear, self.normal, self.shear, self.bend, self.twist, self.bend])


@dataclass(frozen=True, eq=False)
class Patch:
    """Contact area of both pads with an item.

    Attributes:
        middle: (3,) m in the tool frame.
        sides: m along x and z of the tool frame.
    """

    middle: Array
    sides: tuple[float, float]

    def ratio(self, wrench: Array, force: float, friction: float) -> float:
        """Compute the load over the limits of the contact area; the pads hold up to 1.

        Args:
            wrench: (6,) that the pads exert on the item, about the tip, in the tool frame.
            force: N with which each pad presses.
            friction: Coefficient of friction between pads and item.

        Returns:
            The share.
        """
        about = wrench.copy()
        about[3:] -= np.cross(self.middle, wrench[:3])
        return float(PinchLimits(force, friction, self.sides).ratio(about))


def patch_on(shape: Shape, T_item_tip: Array, width: float, gripper: ParallelGripper) -> Patch | None:
    """Compute the contact area of the pads with an item.

    Args:
        shape: Shape of the item.
        T_item_tip: (4, 4) tool frame in the item's.
        width: m between the pads.
        gripper: The gripper.

    Returns:
        The area, or None if a pad does not touch the item, or nowhere opposite to the other's contact.
    """
    at = (np.arange(N_POINTS) + 0.5) / N_POINTS - 0.5
    x, z = (grid.ravel() for grid in np.meshgrid(at * gripper.pad[0], at * gripper.pad[1]))
    touches = np.ones(len(x), dtype=bool)
    for side in (-1.0, 1.0):
        on_pad = np.column_stack([x, np.full(len(x), side * width / 2), z])
        gaps = _distances(shape, transform_points(T_item_tip, on_pad))
        touches &= gaps <= min(gaps.min(), PAD_COMPRESSION) + PAD_COMPRESSION
    if not touches.any():
        return None
    x, z = x[touches], z[touches]
    sides = np.array([np.ptp(x), np.ptp(z)]) + np.array(gripper.pad) / N_POINTS
    middle = np.array([(x.min() + x.max()) / 2, 0.0, (z.min() + z.max()) / 2])
    return Patch(middle, (float(sides[0]), float(sides[1])))


def _distances(shape: Shape, points: Array) -> Array:
    """Signed distances (N,) in m from points (N, 3) in a shape's frame to its surface; negative inside."""
    if shape.kind is ShapeKind.SPHERE:
        return np.asarray(np.linalg.norm(points, axis=1) - shape.size[0])
    if shape.kind is ShapeKind.CYLINDER:
        radius, length = shape.size
        beyond = np.column_stack(
            [np.hypot(points[:, 0], points[:, 1]) - radius, np.abs(points[:, 2]) - length / 2]
        )
    else:
        beyond = np.abs(points) - shape.extents / 2
    outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
    return np.asarray(outside + np.minimum(beyond.max(axis=1), 0.0))
