"""Whether two solids overlap, and how deep.

A direction in which the shadows of both solids overlap by at most d proves that moving one of them by d
parts them. Boxes need only the fifteen directions of the separating axis theorem, so there the depth is
exact. Round solids are first tried along the directions that usually part them; if none does, the solids
shrunk by half the tolerance each are parted by Gilbert's algorithm, so bodies that merely touch are never
called overlapping.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array

TOUCH = 0.0015  # m: as deep as settled items may stand in each other (contact margins and rounding)

_MAX_ITERATIONS = 300
_PARALLEL = 1e-9  # length of a cross product under which it is no direction
_ROUNDING = 1e-9  # m between two solids under which a plane between them may be rounding alone


@dataclass(frozen=True, eq=False)
class Solid:
    """A shape where it stands."""

    shape: Shape
    T: Array  # (4, 4) in any common frame

    @property
    def center(self) -> Array:
        """Its middle (3,)."""
        return np.asarray(self.T[:3, 3])

    @property
    def radius(self) -> float:
        """Of the sphere around it, m."""
        return float(np.linalg.norm(self.shape.extents)) / 2

    def support(self, direction: Array) -> Array:
        """The point (3,) of the solid farthest along a direction (3,)."""
        return np.asarray(
            self.center + self.T[:3, :3] @ _local_support(self.shape, self.T[:3, :3].T @ direction)
        )

    def shrunk(self, by: float) -> Solid:
        """The solid with ``by`` m taken off every side (a sliver where it is thinner than that)."""
        by = min(by, 0.49 * float(self.shape.extents.min()))
        return Solid(self.shape.inflated(-by), self.T)


def overlap_depth(a: Solid, b: Solid, tolerance: float = TOUCH) -> float:
    """How deep two solids stand in each other, m; 0 where it is at most ``tolerance``.

    Exact for two boxes; for round ones never under the true depth and 0 whenever a motion of the
    tolerance parts them.
    """
    if np.linalg.norm(b.center - a.center) >= a.radius + b.radius:
        return 0.0
    depth = np.inf
    for n in _directions(a, b):
        depth = min(depth, _shadow_overlap(a, b, n))
        if depth <= tolerance:
            return 0.0
    both_boxes = a.shape.kind is ShapeKind.BOX and b.shape.kind is ShapeKind.BOX
    if not both_boxes and _are_apart(a.shrunk(tolerance / 2), b.shrunk(tolerance / 2)):
        return 0.0
    return depth


def _local_support(shape: Shape, n: Array) -> Array:
    """The farthest point (3,) of a shape along n (3,), in its own frame."""
    if shape.kind is ShapeKind.BOX:
        return np.asarray(np.copysign(shape.extents / 2, n))
    if shape.kind is ShapeKind.SPHERE:
        return np.asarray(n * (shape.size[0] / max(float(np.linalg.norm(n)), 1e-300)))
    radius, length = shape.size
    across = float(np.hypot(n[0], n[1]))
    outwards = radius / across if across > 1e-12 else 0.0
    return np.array([n[0] * outwards, n[1] * outwards, np.copysign(length / 2, n[2])])


def _shadow_overlap(a: Solid, b: Solid, n: Array) -> float:
    """How far the shadows of both overlap along a unit direction, with b on the side n points to."""
    return float(n @ (a.support(n) - b.support(-n)))


def _directions(a: Solid, b: Solid) -> list[Array]:
    """Unit directions that may part the two, each with its opposite."""
    axes_a, axes_b = list(a.T[:3, :3].T), list(b.T[:3, :3].T)
    candidates = [b.center - a.center, *axes_a, *axes_b]
    candidates += [np.cross(u, v) for u in axes_a for v in axes_b]
    for one, other in ((a, b), (b, a)):
        if one.shape.kind is not ShapeKind.BOX:
            candidates.append(_from_axis(one, other))
    lengths = [float(np.linalg.norm(c)) for c in candidates]
    units = [c / length for c, length in zip(candidates, lengths, strict=True) if length > _PARALLEL]
    return [*units, *(-u for u in units)]


def _from_axis(round_one: Solid, other: Solid) -> Array:
    """From a round solid's axis, where it is nearest to the other's middle, to the other's surface."""
    z, length = round_one.T[:3, 2], round_one.shape.extents[2]
    if round_one.shape.kind is ShapeKind.SPHERE:
        length = 0.0
    along = float(np.clip(z @ (other.center - round_one.center), -length / 2, length / 2))
    p = round_one.center + along * z
    local = other.T[:3, :3].T @ (p - other.center)
    nearest = np.clip(local, -other.shape.extents / 2, other.shape.extents / 2)
    return np.asarray(other.center + other.T[:3, :3] @ nearest - p)


def _are_apart(a: Solid, b: Solid) -> bool:
    """Whether two solids have no common point, by Gilbert's search for the point of A - B nearest to 0."""
    x = a.center - b.center
    for _ in range(_MAX_ITERATIONS):
        s = a.support(-x) - b.support(x)
        if float(x @ s) > _ROUNDING * float(np.linalg.norm(x)):
            return True  # all of A - B lies beyond the plane through s: 0 is outside
        step = s - x
        x = x - float(x @ step) / max(float(step @ step), 1e-300) * step  # between x and s, for x @ s <= 0
        if float(x @ x) < 1e-16:
            return False
    return False
