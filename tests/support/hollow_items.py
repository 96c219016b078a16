"""Items with hollows: a bowl, a card beside a handle, and what is left of a shape without them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from pickcli.cell.hollow import Hollow
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, inverse, transform_points

FACES = ("+x", "-x", "+y", "-y", "+z", "-z")


@st.composite
def round_hollows(draw: st.DrawFn) -> tuple[Shape, Hollow]:
    """A cylinder and a hollow in one of its ends."""
    outer, length = draw(st.floats(0.02, 0.2)), draw(st.floats(0.02, 0.3))
    inner, depth = draw(st.floats(0.2, 0.9)) * outer, draw(st.floats(0.1, 0.9)) * length
    face = draw(st.sampled_from(FACES[-2:]))
    return Shape(ShapeKind.CYLINDER, (outer, length)), Hollow("bowl", face, depth, inner)


@st.composite
def rectangular_hollows(draw: st.DrawFn) -> tuple[Shape, Hollow]:
    """A box and a hollow in one of its faces, some of whose sides are open."""
    shape = Shape(ShapeKind.BOX, tuple(draw(st.floats(0.03, 0.4)) for _ in range(3)))
    face = draw(st.sampled_from(FACES))
    axis = "xyz".index(face[1])
    sides = []
    for half in np.delete(shape.extents / 2, axis).tolist():
        low, high = draw(st.floats(-1.0, 0.2)), draw(st.floats(0.4, 1.0))
        sides.append((half * (-1.0 if low < -0.8 else low), half * (1.0 if high > 0.9 else high)))
    depth = draw(st.floats(0.1, 0.9)) * float(shape.extents[axis])
    return shape, Hollow("pocket", face, depth, None, tuple(sides))


def points_around(shape: Shape, n: int, seed: int = 0) -> Array:
    """Points (n, 3) in m in the box around a shape and just outside of it."""
    rng = np.random.default_rng(seed)
    return np.asarray(rng.uniform(-0.55, 0.55, (n, 3)) * shape.extents)


def are_in_any(points: Array, solids: Iterable[tuple[Shape, Array]]) -> NDArray[np.bool_]:
    """Which points (N, 3) are in any of some solids, each with its pose (4, 4)."""
    found = np.zeros(len(points), dtype=bool)
    for shape, T in solids:
        local = transform_points(inverse(T), points)
        found |= _are_in_hull(local, shape) if shape.kind is ShapeKind.HULL else shape.contains(local)
    return found


def _are_in_hull(points: Array, shape: Shape) -> NDArray[np.bool_]:
    """Inside of all planes through corners with the others on one side (no library of the product)."""
    corners = np.array(shape.vertices)
    inside = np.ones(len(points), dtype=bool)
    for i in range(len(corners)):
        for j in range(i):
            for k in range(j):
                normal = np.cross(corners[j] - corners[i], corners[k] - corners[i])
                off = (corners - corners[i]) @ normal
                if off.max() <= 1e-12:
                    inside &= (points - corners[i]) @ normal <= 1e-12
                elif off.min() >= -1e-12:
                    inside &= (points - corners[i]) @ normal >= -1e-12
    return inside
