"""Overlap depth of two solids.

The depth is the least translation that separates them, over the directions tried in ``touching``: exact for
boxes. If no direction separates round solids, they are shrunk by the tolerance and tested with Gilbert's
algorithm, so that solids in mere contact never count as overlapping. If one is a sphere only it is shrunk,
which is exact; otherwise both are shrunk by half of the tolerance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array
from pickcli.scene.touching import PosedSolids, gaps

TOUCH = 0.0015  # m, overlap of settled items by contact margins and rounding

_MAX_ITERATIONS = 300
_ROUNDING = 1e-9  # m, distance between two solids within rounding errors


@dataclass(frozen=True, eq=False)
class PosedSolid:
    """A shape with its pose.

    Attributes:
        shape: The shape.
        T: (4, 4) pose in any common frame.
    """

    shape: Shape
    T: Array

    @property
    def center(self) -> Array:
        """Centre of the shape, (3,)."""
        return np.asarray(self.T[:3, 3])

    def support(self, direction: Array) -> Array:
        """Compute the farthest point of the solid in a direction.

        Args:
            direction: (3,).

        Returns:
            (3,).
        """
        return np.asarray(
            self.center + self.T[:3, :3] @ _local_support(self.shape, self.T[:3, :3].T @ direction)
        )

    def shrunk(self, by: float) -> PosedSolid:
        """Return the solid with every side moved inwards, or a sliver if it is thinner than that.

        Args:
            by: m.

        Returns:
            The smaller solid.
        """
        by = min(by, 0.49 * float(self.shape.extents.min()))
        return PosedSolid(self.shape.inflated(-by), self.T)


def overlap_depth(a: PosedSolid, b: PosedSolid, tolerance: float = TOUCH) -> float:
    """Compute the overlap depth of two solids.

    Exact for two boxes. With round solids it is at least the true depth, and 0 if a translation by the
    tolerance separates them. One exception: a cylinder's rim in the corner of a box may be 1.5 times the
    tolerance deep and still count as touching.

    Args:
        a: One solid.
        b: The other, in the same frame.
        tolerance: m, depth that counts as contact.

    Returns:
        m; 0 if it is at most the tolerance.
    """
    pair = PosedSolids.standing([(solid.shape, solid.T) for solid in (a, b)])
    depth = -float(gaps(pair, np.array([0]), np.array([1])).width[0])
    if depth <= tolerance:
        return 0.0
    both_boxes = a.shape.kind is ShapeKind.BOX and b.shape.kind is ShapeKind.BOX
    if not both_boxes and _are_apart(*_shrunk(a, b, tolerance)):
        return 0.0
    return depth


def _shrunk(a: PosedSolid, b: PosedSolid, by: float) -> tuple[PosedSolid, PosedSolid]:
    """Shrink two solids such that they overlap unless a translation by at most ``by`` (m) parts them."""
    if a.shape.kind is ShapeKind.SPHERE and by < a.shape.size[0]:
        return a.shrunk(by), b
    if b.shape.kind is ShapeKind.SPHERE and by < b.shape.size[0]:
        return a, b.shrunk(by)
    return a.shrunk(by / 2), b.shrunk(by / 2)


def _local_support(shape: Shape, n: Array) -> Array:
    """Farthest point (3,) of a shape in direction n (3,), in its own frame."""
    if shape.kind is ShapeKind.BOX:
        return np.asarray(np.copysign(shape.extents / 2, n))
    if shape.kind is ShapeKind.SPHERE:
        return np.asarray(n * (shape.size[0] / np.linalg.norm(n)))
    radius, length = shape.size
    around = np.arctan2(n[1], n[0])
    return np.array([radius * np.cos(around), radius * np.sin(around), np.copysign(length / 2, n[2])])


def _are_apart(a: PosedSolid, b: PosedSolid) -> bool:
    """Whether two solids are disjoint, by Gilbert's search for the point of A - B nearest to 0."""
    x = a.center - b.center
    for _ in range(_MAX_ITERATIONS):
        if np.linalg.norm(x) <= _ROUNDING:
            return False
        s = a.support(-x) - b.support(x)
        if float(x @ s) > 0.0:
            return True  # A - B is beyond the plane through s, so 0 is outside
        step = s - x
        x = x - float(x @ step) / float(step @ step) * step  # x @ s <= 0, up to rounding
    return False
