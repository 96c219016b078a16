"""Spheres that provably contain a solid, or a link made of several.

Proof of containment. A ball is convex, so it contains a cell (a box, or a sector of a ring) if it contains
the cell's farthest point, which is one of its corners or, on a ring, an end of its outer or inner arc. The
cells partition the solid and each lies inside one ball, so the union of the balls contains the solid. Flat
boxes and capsules are covered by a lattice and by a row whose coverage is elementary geometry (see
`solid_covers`).

Excess. For a ball of radius r around a point at depth d inside a convex solid, the farthest that any point of
the ball lies outside the solid is exactly r - d: the distance to a convex set is the largest over its
supporting half-spaces, and the nearest of those is d away from the centre.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.collision.solid_covers import Spheres, cover_box, cover_capsule, cover_cylinder
from pickcli.files.derived_cache import content_key, derived
from pickcli.geometry import Array, transform_points

MAX_EXCESS = 0.007  # m, default for how far a sphere may stick out of its solid
MAX_COUNT = 150  # default for the number of spheres of one solid; the excess grows if more were needed

# Guards the proof against rounding: radii grow by this much, far above 1e-16 and far below any clearance.
_ROUNDING = 1e-9
_AT_ONCE = 32  # spheres that are compared with all larger ones per batch

_VERSION = "1"  # of the cover of hulls: increase it with every change of that

# m, distance of a ball from a cylinder's end to count as its dome: only the stated excess depends on it.
_DOME_TOLERANCE = 1e-4


@dataclass(frozen=True, eq=False)
class Cover:
    """Spheres in the frame of the solid (or link) that they contain.

    Attributes:
        centers: (S, 3) m.
        radii: (S,) m.
        excess: m, largest distance of any point of a sphere outside the solid.
    """

    centers: Array
    radii: Array
    excess: float

    def moved(self, T_parent_solid: Array) -> Cover:
        """Transform the spheres to a parent frame.

        Args:
            T_parent_solid: (4, 4) pose of the solid's frame in the parent's.

        Returns:
            The spheres in the parent's frame.
        """
        return Cover(transform_points(T_parent_solid, self.centers), self.radii, self.excess)

    def inflated(self, by: float) -> Cover:
        """Return spheres around an enlarged solid.

        Args:
            by: m.

        Returns:
            Spheres that contain every point within ``by`` of the solid.
        """
        return Cover(self.centers, self.radii + by, self.excess)

    def joined(self, other: Cover) -> Cover:
        """Join two covers in one frame.

        Args:
            other: The other cover.

        Returns:
            Spheres that contain both solids.
        """
        return Cover(
            np.concatenate([self.centers, other.centers]),
            np.concatenate([self.radii, other.radii]),
            max(self.excess, other.excess),
        )


@lru_cache(maxsize=512)
def cover_shape(shape: Shape, max_excess: float = MAX_EXCESS, max_count: int = MAX_COUNT) -> Cover:
    """Cover a shape with few tight spheres.

    Args:
        shape: The shape.
        max_excess: m, how far they may stick out. It grows by steps of 5 % (20 % while far off) while more
            than ``max_count`` spheres would be needed; ``Cover.excess`` states the result.
        max_count: Most spheres.

    Returns:
        The spheres, in the shape's own frame.
    """
    if shape.kind is ShapeKind.SPHERE:
        return Cover(np.zeros((1, 3)), np.array([shape.size[0]]), 0.0)
    excess = max_excess
    while _fewest_possible(shape, excess) > max_count:
        excess *= 1.1
    while (spheres := _spheres(shape, excess)) is None or len(spheres[1]) > max_count:
        is_close = spheres is not None and len(spheres[1]) <= 1.3 * max_count
        excess *= 1.05 if is_close else 1.2
    centers, radii = spheres
    reached = float((radii - _depth(shape, centers)).max())
    return Cover(centers, radii + _ROUNDING, reached + _ROUNDING)


def cover_bodies(
    bodies: Sequence[Body], max_excess: Callable[[Body], float], max_count: int = MAX_COUNT
) -> Cover:
    """Cover several bodies with spheres.

    A cylinder with balls of at least its radius at both ends is covered as a capsule. Spheres inside another
    are dropped.

    Args:
        bodies: The bodies.
        max_excess: Bound in m of how far spheres may stick out, for each body.
        max_count: Most spheres of each body.

    Returns:
        The spheres, in the bodies' common parent frame (a link's, for its shapes).
    """
    if not bodies:
        return Cover(np.zeros((0, 3)), np.zeros(0), 0.0)
    covers = []
    for body in bodies:
        bound = max_excess(body)
        is_domed = _is_domed(body, bodies)
        cover = _cover_domed(body.shape, bound) if is_domed else cover_shape(body.shape, bound, max_count)
        covers.append(cover.moved(body.T_parent_shape))
    centers, radii = np.concatenate([c.centers for c in covers]), np.concatenate([c.radii for c in covers])
    kept = outermost(centers, radii)
    return Cover(centers[kept], radii[kept], max(c.excess for c in covers))


def cover_meshes(hulls: Sequence[Body], excess: float, max_excess: float, max_count: int) -> Cover:
    """Cover the convex pieces of a link's meshes with spheres, cached in the user's cache.

    Args:
        hulls: The pieces.
        excess: m, how far the spheres may stick out if they are few enough.
        max_excess: m, how far they may stick out at most, for any number; more if the solid is too large.
        max_count: Most spheres, if ``max_excess`` allows it.

    Returns:
        The spheres, in the pieces' common parent frame.
    """
    if not hulls:
        return Cover(np.zeros((0, 3)), np.zeros(0), 0.0)
    from pickcli.collision.hull_cover import cover_hulls, depths  # slow to import, needed only for meshes

    pieces = [transform_points(hull.T_parent_shape, np.array(hull.shape.vertices)) for hull in hulls]

    def derive() -> list[Any]:
        centers, radii = cover_hulls(pieces, excess, max_excess, max_count)
        return [centers.tolist(), radii.tolist()]

    settings = repr((_VERSION, excess, max_excess, max_count))
    key = content_key(settings, *(np.ascontiguousarray(piece).tobytes() for piece in pieces))
    centers, radii = map(np.array, derived("spheres", key, derive))
    reached = float((radii - depths(pieces, centers)).max())
    return Cover(centers, radii + _ROUNDING, reached + _ROUNDING)


def _fewest_possible(shape: Shape, excess: float) -> float:
    """Return a lower bound of the number of spheres, by the area of the largest flat face.

    A ball of radius r, at depth d, meets a face in a disc of squared radius at most r^2 - d^2, which is at
    most excess (2 d + excess); and no point is deeper than half the smallest extent.
    """
    a, b, thinnest = sorted(shape.extents, reverse=True)
    face = a * b if shape.kind is ShapeKind.BOX else np.pi * shape.size[0] ** 2
    return float(face / (np.pi * excess * (thinnest + excess)))


def _spheres(shape: Shape, excess: float) -> Spheres | None:
    if shape.kind is ShapeKind.BOX:
        return cover_box(shape.extents, excess)
    radius, length = shape.size
    return cover_cylinder(radius, length, excess)


def _depth(shape: Shape, points: Array) -> Array:
    """Return (N,) distances of inner points (N, 3) to the surface of a box or cylinder."""
    if shape.kind is ShapeKind.BOX:
        return np.asarray((shape.extents / 2 - np.abs(points)).min(axis=1))
    radius, length = shape.size
    return np.minimum(radius - np.hypot(points[:, 0], points[:, 1]), length / 2 - np.abs(points[:, 2]))


def _cover_domed(cylinder: Shape, max_excess: float) -> Cover:
    radius, length = cylinder.size
    centers, radii = cover_capsule(radius, length, max_excess)
    return Cover(centers, radii + _ROUNDING, float(radii[0]) - radius + _DOME_TOLERANCE)


def _is_domed(body: Body, bodies: Sequence[Body]) -> bool:
    """Whether both ends of a cylinder have balls of at least its radius."""
    if body.shape.kind is not ShapeKind.CYLINDER:
        return False
    radius, length = body.shape.size
    ends = transform_points(body.T_parent_shape, np.array([[0, 0, -length / 2], [0, 0, length / 2]]))
    balls = [b for b in bodies if b.shape.kind is ShapeKind.SPHERE and b.shape.size[0] >= radius]
    return all(
        any(np.linalg.norm(b.T_parent_shape[:3, 3] - e) < _DOME_TOLERANCE for b in balls) for e in ends
    )


def outermost(centers: Array, radii: Array) -> Array:
    """Find the spheres that no other one contains.

    Args:
        centers: (S, 3) m.
        radii: (S,) m.

    Returns:
        (K,) their indices, sorted; the first of equal spheres.
    """
    order = np.argsort(-radii, kind="stable")
    (x, y, z), r = np.ascontiguousarray(centers[order].T), radii[order]
    is_inside = np.zeros(len(r), dtype=bool)
    for first in range(0, len(r), _AT_ONCE):
        some, larger = slice(first, first + _AT_ONCE), slice(first + _AT_ONCE)
        squares = sum((p[None, larger] - p[some, None]) ** 2 for p in (x, y, z))
        is_within = np.sqrt(squares) + r[some, None] <= r[None, larger]
        is_inside[some] = np.tril(is_within, first - 1).any(axis=1)
    return np.sort(order[~is_inside])
