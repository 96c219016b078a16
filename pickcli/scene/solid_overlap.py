"""Whether two solids overlap, and how deep.

The least push of the directions tried in ``touching`` is the depth: exact for boxes. Where it parts no round
solids, they are shrunk by the tolerance and parted by Gilbert's algorithm, so bodies that merely touch are
never called overlapping: a ball alone, which loses as much in every direction, else both by half of it each.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array
from pickcli.scene.touching import PosedSolids, gaps

TOUCH = 0.0015  # m: as deep as settled items may stand in each other (contact margins and rounding)

_MAX_ITERATIONS = 300
_ROUNDING = 1e-9  # m, a distance between two solids that may be rounding alone


@dataclass(frozen=True, eq=False)
class PosedSolid:
    """A shape where it stands.

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
        """The point of the solid that is farthest along a direction.

        Args:
            direction: (3,).

        Returns:
            (3,).
        """
        return np.asarray(
            self.center + self.T[:3, :3] @ _local_support(self.shape, self.T[:3, :3].T @ direction)
        )

    def shrunk(self, by: float) -> PosedSolid:
        """The solid with every side moved inwards (a sliver where it is thinner than that).

        Args:
            by: m.

        Returns:
            The smaller solid.
        """
        by = min(by, 0.49 * float(self.shape.extents.min()))
        return PosedSolid(self.shape.inflated(-by), self.T)


def overlap_depth(a: PosedSolid, b: PosedSolid, tolerance: float = TOUCH) -> float:
    """How deep two solids stand in each other.

    Exact for two boxes. For round ones never under the true depth, except for cylinders, of which the rim may
    stand half as deep again as the tolerance in the corner of a box and count as touching; and 0 whenever a
    motion of the tolerance parts them.

    Args:
        a: One solid.
        b: The other, in the same frame.
        tolerance: m of depth that does not count.

    Returns:
        m; 0 where it is at most the tolerance.
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
    """Two solids that no motion of at most ``by`` (m) parts, if these are not apart."""
    if a.shape.kind is ShapeKind.SPHERE and by < a.shape.size[0]:
        return a.shrunk(by), b
    if b.shape.kind is ShapeKind.SPHERE and by < b.shape.size[0]:
        return a, b.shrunk(by)
    return a.shrunk(by / 2), b.shrunk(by / 2)


def _local_support(shape: Shape, n: Array) -> Array:
    """The farthest point (3,) of a shape along n (3,), in its own frame."""
    if shape.kind is ShapeKind.BOX:
        return np.asarray(np.copysign(shape.extents / 2, n))
    if shape.kind is ShapeKind.SPHERE:
        return np.asarray(n * (shape.size[0] / np.linalg.norm(n)))
    radius, length = shape.size
    around = np.arctan2(n[1], n[0])
    return np.array([radius * np.cos(around), radius * np.sin(around), np.copysign(length / 2, n[2])])


def _are_apart(a: PosedSolid, b: PosedSolid) -> bool:
    """Whether two solids have no common point, by Gilbert's search for the point of A - B nearest to 0."""
    x = a.center - b.center
    for _ in range(_MAX_ITERATIONS):
        if np.linalg.norm(x) <= _ROUNDING:
            return False
        s = a.support(-x) - b.support(x)
        if float(x @ s) > 0.0:
            return True  # all of A - B lies beyond the plane through s: 0 is outside
        step = s - x
        x = x - float(x @ step) / float(step @ step) * step  # between x and s, for x @ s is about 0 or below
    return False
