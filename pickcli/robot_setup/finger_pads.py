"""Finds the flat pads of two fingers in their collision shapes: where both are flat and face each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.geometry import Array

GRID_STEP = 0.0005  # m, side of the grid cells that form pads
MOST_CELLS = 200  # along a side; cells are larger on longer fingers
MAX_UNEVENNESS = 0.0003  # m, tolerated unevenness of a pad's face
MIN_PAD_DEPTH = 0.002  # m behind the face within which a pad must be solid
MIN_PAD_WIDTH = 0.003  # m, least width of a pad

_N_SIDES = 64  # of the prism that approximates a cylinder


@dataclass(frozen=True, eq=False)
class FingerPads:
    """Two pads of equal size that face each other.

    Attributes:
        middle: (3,) m, the middle between both, in the frame of the fingers' shapes.
        size: m, their sides along x and z of that frame.
        gap: m between their faces along y.
    """

    middle: Array
    size: tuple[float, float]
    gap: float

    def ending(self, most: float) -> FingerPads:
        """Return the outer ends of pads that are longer along z: those that reach items on a floor.

        Args:
            most: m along z.

        Returns:
            The pads, at most that long, with the same end on the +z side.
        """
        along_x, along_z = self.size
        kept = min(along_z, most)
        outwards = np.array([0.0, 0.0, (along_z - kept) / 2])
        return FingerPads(self.middle + outwards, (along_x, kept), self.gap)


def find_pads(upper: Sequence[Body], lower: Sequence[Body]) -> FingerPads | None:
    """Find the largest rectangle on which both fingers are flat and solid.

    Args:
        upper: Shapes of the finger on the +y side, with ``T_parent_shape`` in a frame whose y is the
            closing direction.
        lower: Shapes of the finger on the -y side, in the same frame.

    Returns:
        The pads; None if there is no rectangle at least ``MIN_PAD_WIDTH`` wide.
    """
    corners = [_box_around(shapes) for shapes in (upper, lower)]
    low = np.max([low for low, _ in corners], axis=0)
    high = np.min([high for _, high in corners], axis=0)
    if (high - low < MIN_PAD_WIDTH).any():
        return None
    n = np.minimum(np.floor((high - low) / GRID_STEP), MOST_CELLS).astype(int)
    sides = (high - low) / n
    x, z = (low[k] + sides[k] * (np.arange(n[k]) + 0.5) for k in range(2))
    columns = np.stack(np.meshgrid(x, z, indexing="ij"), axis=-1).reshape(-1, 2)
    above, below = _inner_face(upper, columns, 1.0), _inner_face(lower, columns, -1.0)
    if above is None or below is None:
        return None
    first, last = _largest_rectangle((above[1] & below[1]).reshape(*n))
    size = sides * (last - first - 1)  # cells at the rim are included only by their centres
    if size.min() < MIN_PAD_WIDTH:
        return None
    middle = low + sides * (first + last) / 2
    face, opposite = above[0], below[0]
    center = np.array([middle[0], (face + opposite) / 2, middle[1]])
    return FingerPads(center, (float(size[0]), float(size[1])), float(face - opposite))


def _box_around(shapes: Sequence[Body]) -> tuple[Array, Array]:
    """Lower and upper corner (2,), (2,) of a finger along x and z."""
    ends = [(body.T_parent_shape[:3, 3], body.shape.reach(body.T_parent_shape[:3, :3])) for body in shapes]
    low = np.min([center - half for center, half in ends], axis=0)
    high = np.max([center + half for center, half in ends], axis=0)
    return low[[0, 2]], high[[0, 2]]


def _inner_face(
    shapes: Sequence[Body], columns: Array, side: float
) -> tuple[float, NDArray[np.bool_]] | None:
    """Position of a finger's face along y, and mask of the columns (N, 2) where it is flat and solid behind.

    Fingers on the -y side are mirrored. None if no column hits the finger.
    """
    spans = [_span(body, columns, side) for body in shapes]
    begins = np.min([begin for begin, _ in spans], axis=0)
    if not np.isfinite(begins).any():
        return None
    face = float(begins.min())
    is_solid = np.any(
        [(begin <= face + MAX_UNEVENNESS) & (end >= face + MIN_PAD_DEPTH) for begin, end in spans], axis=0
    )
    return side * face, is_solid


def _span(body: Body, columns: Array, side: float) -> tuple[Array, Array]:
    """Entry and exit (N,) of lines along y, at x and z (N, 2), through a solid. Infinite for a miss."""
    T = body.T_parent_shape
    normals, offsets = _planes(body.shape)
    normals = normals @ T[:3, :3].T
    offsets = offsets - normals @ T[:3, 3]
    along = side * normals[:, 1]
    across = columns @ normals[:, [0, 2]].T + offsets  # value at y = 0
    with np.errstate(divide="ignore", invalid="ignore"):
        t = -across / along
    enters = np.where(along < 0.0, t, -np.inf).max(axis=1)
    leaves = np.where(along > 0.0, t, np.inf).min(axis=1)
    misses = ((along == 0.0) & (across > 0.0)).any(axis=1) | (enters > leaves)
    return np.where(misses, np.inf, enters), np.where(misses, -np.inf, leaves)


def _planes(shape: Shape) -> tuple[Array, Array]:
    """Outward normals (M, 3) and offsets (M,) of a convex solid, with ``normal @ p + offset <= 0`` inside.

    A cylinder is approximated by an inscribed prism; a sphere has no flat face, so its planes exclude every
    point.
    """
    if shape.kind is ShapeKind.HULL:
        from scipy.spatial import ConvexHull  # slow to import; only for fingers with meshes

        planes = ConvexHull(np.array(shape.vertices)).equations
        return planes[:, :3], planes[:, 3]
    if shape.kind is ShapeKind.BOX:
        return np.vstack([np.eye(3), -np.eye(3)]), -np.tile(np.array(shape.size) / 2, 2)
    if shape.kind is ShapeKind.SPHERE:
        return np.vstack([np.eye(3), -np.eye(3)]), np.ones(6)
    radius, length = shape.size
    angles = np.arange(_N_SIDES) * (2 * np.pi / _N_SIDES)
    around = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(_N_SIDES)])
    inner = radius * np.cos(np.pi / _N_SIDES)
    ends = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    return np.vstack([around, ends]), -np.concatenate([np.full(_N_SIDES, inner), [length / 2] * 2])


def _largest_rectangle(mask: NDArray[np.bool_]) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
    """First and past-the-last row and column, (2,) each, of the largest rectangle that is all true.

    For every row, the runs of true cells that end in it form a histogram, whose largest rectangle is found
    with a stack.
    """
    best, found = 0, (np.zeros(2, dtype=int), np.zeros(2, dtype=int))
    heights = np.zeros(mask.shape[1] + 1, dtype=int)
    for row, cells in enumerate(mask):
        heights[:-1] = np.where(cells, heights[:-1] + 1, 0)
        open_from: list[tuple[int, int]] = []
        for column, height in enumerate(heights.tolist()):
            begin = column
            while open_from and open_from[-1][1] >= height:
                begin, tall = open_from.pop()
                if tall * (column - begin) > best:
                    best = tall * (column - begin)
                    found = np.array([row + 1 - tall, begin]), np.array([row + 1, column])
            open_from.append((begin, height))
    return found
