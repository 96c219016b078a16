"""Gaps and contact normals between pairs of convex solids, vectorised.

The gap of two convex solids in a direction is the width of the empty slab between them; the largest over all
directions is their distance or, if they overlap, minus the least translation that separates them. Twenty
directions are tried at once for all pairs: the fifteen of the separating axis theorem (Gottschalk, Lin and
Manocha, OBBTree, 1996), the line of centres, and four for round sides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.geometry import Array
from pickcli.scene.scene import PlacedItem, Scene

_KINDS = {ShapeKind.BOX: 0, ShapeKind.CYLINDER: 1, ShapeKind.SPHERE: 2}
_MIN_LENGTH = 1e-9  # vectors shorter than this have no direction


@dataclass(frozen=True, eq=False)
class PosedSolids:
    """N posed solids, as arrays.

    Attributes:
        names: (N,) ids of items, names of bodies.
        shapes: (N,) shapes.
        T: (N, 4, 4) poses in the world.
        half: (N, 3) m, half extents of each bounding box in the solid's own frame.
        kinds: (N,) numbers of the shape kinds, as in ``_KINDS``.
        bound: (N,) m, bound of the position error of any point of each solid.
    """

    names: tuple[str, ...]
    shapes: tuple[Shape, ...]
    T: Array
    half: Array
    kinds: NDArray[np.intp]
    bound: Array

    @classmethod
    def of(
        cls, scene: Scene, items: Sequence[PlacedItem], bodies: Sequence[tuple[Body, Array]]
    ) -> PosedSolids:
        """Collect items and bodies of a scene.

        Args:
            scene: The scene, for the bounds of the items' pose errors.
            items: The items.
            bodies: Bodies with the poses (4, 4) of their parent frames.

        Returns:
            The items, then the bodies.
        """
        standing = [(placed.item.shape, placed.T_world_item) for placed in items]
        standing += [(body.shape, T @ body.T_parent_shape) for body, T in bodies]
        names = (*(placed.id for placed in items), *(body.name for body, _ in bodies))
        bounds = [*(scene.bound(placed) for placed in items), *(0.0 for _ in bodies)]
        return replace(cls.standing(standing), names=names, bound=np.array(bounds))

    @classmethod
    def standing(cls, solids: Sequence[tuple[Shape, Array]]) -> PosedSolids:
        """Build solids from shapes with exact poses, without names.

        Args:
            solids: Shapes with their poses (4, 4).

        Returns:
            The solids.
        """
        shapes = tuple(shape for shape, _ in solids)
        return cls(
            ("",) * len(shapes),
            shapes,
            np.array([T for _, T in solids]).reshape(len(shapes), 4, 4),
            np.array([shape.extents / 2 for shape in shapes]).reshape(len(shapes), 3),
            np.array([_KINDS[shape.kind] for shape in shapes], dtype=np.intp),
            np.zeros(len(shapes)),
        )

    def half_widths(self, of: NDArray[np.intp], directions: Array) -> Array:
        """Compute the distances from the centres of solids to their supporting planes.

        Args:
            of: (P,) indices of solids.
            directions: (P, D, 3) unit vectors in the world.

        Returns:
            (P, D) m.
        """
        local = np.abs(directions @ self.T[of, :3, :3])
        half, kind = self.half[of], self.kinds[of][:, None]
        as_box = np.einsum("pdk,pk->pd", local, half)
        around = half[:, None, 0] * np.hypot(local[..., 0], local[..., 1]) + half[:, None, 2] * local[..., 2]
        return np.where(kind == 0, as_box, np.where(kind == 1, around, half[:, :1]))

    @cached_property
    def upright(self) -> Array:
        """Half extents (N, 3) in m of the boxes around the solids along the world's axes."""
        n = len(self.names)
        return self.half_widths(np.arange(n), np.broadcast_to(np.eye(3), (n, 3, 3)))

    def near(self, n_items: int, reach: float = 0.0) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Find pairs whose world-aligned boxes are within a distance, plus both error bounds.

        Args:
            n_items: Number of items, which are the first of the solids.
            reach: m, the distance.

        Returns:
            Indices (P,) and (P,) of both; the first is an item.
        """
        half = self.upright + self.bound[:, None] + reach / 2
        low, high = self.T[:, :3, 3] - half, self.T[:, :3, 3] + half
        meet = (low[:n_items, None] <= high) & (high[:n_items, None] >= low)
        a, b = np.nonzero(meet.all(axis=2))
        return a[a < b], b[a < b]


@dataclass(frozen=True, eq=False)
class Gaps:
    """P pairs of solids with their gaps.

    Attributes:
        a: (P,) indices of one solid.
        b: (P,) indices of the other.
        width: (P,) m, largest gap; negative if they overlap.
        normal: (P, 3) unit vector in the direction of that gap, from ``a`` to ``b``.
    """

    a: NDArray[np.intp]
    b: NDArray[np.intp]
    width: Array
    normal: Array


def gaps(solids: PosedSolids, a: NDArray[np.intp], b: NDArray[np.intp]) -> Gaps:
    """Compute the largest gap of each pair over the directions that can separate boxes and round solids.

    Args:
        solids: The solids.
        a: (P,) indices of one solid.
        b: (P,) indices of the other.

    Returns:
        The gaps.
    """
    between = solids.T[b, :3, 3] - solids.T[a, :3, 3]
    directions = _directions(solids, a, b, between)
    lengths = np.linalg.norm(directions, axis=2)
    unit = directions / np.maximum(lengths, _MIN_LENGTH)[..., None]
    along = np.einsum("pdk,pk->pd", unit, between)
    widths = np.abs(along) - solids.half_widths(a, unit) - solids.half_widths(b, unit)
    widths[lengths <= _MIN_LENGTH] = -np.inf
    best = widths.argmax(axis=1)
    rows = np.arange(len(a))
    across = unit[rows, best]
    normal = np.where(along[rows, best, None] < 0.0, -across, across)
    return Gaps(a, b, widths[rows, best], normal)


def _directions(solids: PosedSolids, a: NDArray[np.intp], b: NDArray[np.intp], between: Array) -> Array:
    """Candidate directions (P, 20, 3) that may separate each pair, of any length and sign."""
    axes_a, axes_b = (solids.T[of, :3, :3].transpose(0, 2, 1) for of in (a, b))
    edges = np.cross(axes_a[:, :, None], axes_b[:, None]).reshape(len(a), 9, 3)
    radial = [
        between - axis * np.einsum("pk,pk->p", axis, between)[:, None]
        for axis in (axes_a[:, 2], axes_b[:, 2])
    ]
    nearest = [_from_axis(solids, a, b), _from_axis(solids, b, a)]
    return np.concatenate([axes_a, axes_b, edges, np.stack([between, *radial, *nearest], axis=1)], axis=1)


def _from_axis(solids: PosedSolids, of: NDArray[np.intp], other: NDArray[np.intp]) -> Array:
    """Vectors (P, 3) from the axes of solids ``of``, where nearest to the others' centres, to the others."""
    centre, middle = solids.T[of, :3, 3], solids.T[other, :3, 3]
    axis = solids.T[of, :3, 2]
    length = np.where(solids.kinds[of] == 2, 0.0, solids.half[of, 2])
    along = np.clip(np.einsum("pk,pk->p", axis, middle - centre), -length, length)
    p = centre + along[:, None] * axis
    R = solids.T[other, :3, :3]
    local = np.clip(np.einsum("pji,pj->pi", R, p - middle), -solids.half[other], solids.half[other])
    return np.asarray(middle + np.einsum("pij,pj->pi", R, local) - p)
