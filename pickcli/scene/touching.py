"""Which solids of a scene touch, as far as uncertain poses can tell, and across which direction.

The gap between two convex solids across a direction is the width of the empty slab between them; the widest
over all directions is their distance, or, where they overlap, the least push that parts them. Twenty
directions are tried at once for all pairs: the fifteen of the separating axis theorem (Gottschalk, Lin and
Manocha, OBBTree, 1996), the line of centres, and those in which round sides give way first.
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
_NO_WAY = 1e-9  # length under which a vector is no direction


@dataclass(frozen=True, eq=False)
class PosedSolids:
    """N solids where they stand, in arrays.

    Attributes:
        names: (N,) ids of items, names of bodies.
        shapes: (N,) shapes.
        T: (N, 4, 4) poses in the world.
        half: (N, 3) m, half extents of the box around each in its own frame.
        kinds: (N,) number of each shape's kind.
        bound: (N,) m, how far any point of each may be from where its pose says.
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
        """Items and bodies of a scene.

        Args:
            scene: Its noise bounds the error of the items' poses.
            items: The items.
            bodies: Bodies with the pose (4, 4) of what they stand in.

        Returns:
            The items, then the bodies.
        """
        standing = [(placed.item.shape, placed.T_world_item) for placed in items]
        standing += [(body.shape, T @ body.T_parent_shape) for body, T in bodies]
        names = (*(placed.id for placed in items), *(body.name for body, _ in bodies))
        bounds = [*(scene.noise.bound(placed.item) for placed in items), *(0.0 for _ in bodies)]
        return replace(cls.standing(standing), names=names, bound=np.array(bounds))

    @classmethod
    def standing(cls, solids: Sequence[tuple[Shape, Array]]) -> PosedSolids:
        """Shapes exactly at their poses, without names.

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
        """Distances from the centres of solids to the planes that touch them.

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
        """(N, 3) m, half extents of the boxes around them along the axes of the world."""
        n = len(self.names)
        return self.half_widths(np.arange(n), np.broadcast_to(np.eye(3), (n, 3, 3)))

    def near(self, n_items: int, reach: float = 0.0) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Pairs whose upright boxes come within a reach, and both bounds, of each other.

        Args:
            n_items: How many of the solids, the first ones, are items.
            reach: m.

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
    """P pairs of solids and how far apart they are.

    Attributes:
        a: (P,) indices of one solid.
        b: (P,) indices of the other.
        width: (P,) m, the widest gap; negative where they overlap, by that much.
        normal: (P, 3) unit vector across that gap, from ``a`` to ``b``.
    """

    a: NDArray[np.intp]
    b: NDArray[np.intp]
    width: Array
    normal: Array


def gaps(solids: PosedSolids, a: NDArray[np.intp], b: NDArray[np.intp]) -> Gaps:
    """The widest gap of each pair over the directions that part boxes and round solids.

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
    unit = directions / np.maximum(lengths, _NO_WAY)[..., None]
    along = np.einsum("pdk,pk->pd", unit, between)
    widths = np.abs(along) - solids.half_widths(a, unit) - solids.half_widths(b, unit)
    widths[lengths <= _NO_WAY] = -np.inf
    best = widths.argmax(axis=1)
    rows = np.arange(len(a))
    across = unit[rows, best]
    normal = np.where(along[rows, best, None] < 0.0, -across, across)
    return Gaps(a, b, widths[rows, best], normal)


def _directions(solids: PosedSolids, a: NDArray[np.intp], b: NDArray[np.intp], between: Array) -> Array:
    """(P, 20, 3) vectors that may part each pair, of any length and sign."""
    axes_a, axes_b = (solids.T[of, :3, :3].transpose(0, 2, 1) for of in (a, b))
    edges = np.cross(axes_a[:, :, None], axes_b[:, None]).reshape(len(a), 9, 3)
    radial = [
        between - axis * np.einsum("pk,pk->p", axis, between)[:, None]
        for axis in (axes_a[:, 2], axes_b[:, 2])
    ]
    nearest = [_from_axis(solids, a, b), _from_axis(solids, b, a)]
    return np.concatenate([axes_a, axes_b, edges, np.stack([between, *radial, *nearest], axis=1)], axis=1)


def _from_axis(solids: PosedSolids, of: NDArray[np.intp], other: NDArray[np.intp]) -> Array:
    """(P, 3) from the axes of solids ``of``, where they are nearest to the others' middles, to the others."""
    centre, middle = solids.T[of, :3, 3], solids.T[other, :3, 3]
    axis = solids.T[of, :3, 2]
    length = np.where(solids.kinds[of] == 2, 0.0, solids.half[of, 2])
    along = np.clip(np.einsum("pk,pk->p", axis, middle - centre), -length, length)
    p = centre + along[:, None] * axis
    R = solids.T[other, :3, :3]
    local = np.clip(np.einsum("pji,pj->pi", R, p - middle), -solids.half[other], solids.half[other])
    return np.asarray(middle + np.einsum("pij,pj->pi", R, local) - p)
