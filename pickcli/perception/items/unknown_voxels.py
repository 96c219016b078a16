"""Space of a place that nobody has seen, or in which something is that nothing explains, as boxes.

The room is divided into voxels. Known are those that rays went through, and those in answers, within the
bounds of their errors, and unseen but right beside these. All others are unknown: behind items, beyond the
picture, and where something was measured that is no answer. Runs of unknown voxels are merged into boxes
along the axes of the place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

from pickcli.cell.place import Room
from pickcli.cell.shapes import Shape
from pickcli.geometry import Array, inverse, transform_points
from pickcli.perception.items.line_of_sight import LineOfSight

VOXEL = 0.01  # m
# m around an answer's bounds in which what is merely unseen is not unknown: half a voxel, twice the error of
# a camera's pose, and the clearance that planners keep. With less no item could leave as it stands.
RESERVE = 0.015
ASIDE = 0.05  # m between cameras, below which two looks err alike, and are no second opinion
_BESIDE = np.ones((3, 3, 3))


@dataclass(frozen=True, eq=False)
class RoomVoxels:
    """The voxels of the box around a room.

    Attributes:
        low: (3,) m, lower corner of the box in the place's frame.
        sides: (3,) m, of each voxel, at most ``VOXEL``.
        counts: (3,) numbers along x, y and z.
        middles: (N, 3) m.
        is_room: (N,) whether their middles are between floor and ceiling.
    """

    low: Array
    sides: Array
    counts: NDArray[np.intp]
    middles: Array
    is_room: NDArray[np.bool_]

    @classmethod
    @lru_cache(maxsize=64)
    def of(cls, room: Room) -> RoomVoxels:
        """Divide a room; cached.

        Args:
            room: The room.

        Returns:
            Its voxels.
        """
        counts = np.maximum(np.ceil(room.size / VOXEL - 1e-9).astype(np.intp), 1)
        sides = room.size / counts
        grid = np.stack(np.meshgrid(*(np.arange(n) for n in counts), indexing="ij"), axis=-1)
        middles = room.low + (grid.reshape(-1, 3) + 0.5) * sides
        floor, ceiling = room.floor_at(middles[:, 0]), room.ceiling_at(middles[:, 0])
        is_room = (middles[:, 2] > floor) & (middles[:, 2] < ceiling)
        return cls(room.low, sides, counts, middles, is_room)

    def holding(self, points: Array) -> NDArray[np.intp]:
        """Find the voxels that hold points; what is outside of the box around the room is in none.

        Args:
            points: (P, 3) m in the place's frame.

        Returns:
            Indices of voxels.
        """
        at = np.floor((points - self.low) / self.sides).astype(np.intp)
        at = at[((at >= 0) & (at < self.counts)).all(axis=1)]
        return np.unique(np.ravel_multi_index(tuple(at.T), tuple(self.counts)))

    def boxes(self, is_filled: NDArray[np.bool_]) -> Array:
        """Merge voxels into boxes.

        Args:
            is_filled: (N,) the voxels.

        Returns:
            (B, 2, 3) m, lower and upper corners in the place's frame. Each voxel is in one box.
        """
        return np.asarray(self.low + merged_boxes(is_filled.reshape(self.counts)) * self.sides)


def unknown_boxes(
    room: Room, sights: Sequence[LineOfSight], explained: Sequence[tuple[Shape, Array]]
) -> Array:
    """Collect the unknown space of a room.

    Args:
        room: The room.
        sights: The rays of each picture of its place: what is clear in one is free.
        explained: Shapes with their poses (4, 4) in the place's frame, inside of which nothing is unknown.

    Returns:
        (N, 2, 3) m, lower and upper corners of boxes in the place's frame.
    """
    voxels = RoomVoxels.of(room)
    width = float(voxels.sides.max())
    is_unknown, is_something = voxels.is_room.copy(), np.zeros(len(voxels.middles), dtype=bool)
    for sight in sights:
        is_clear, is_held = sight.cubes(voxels.middles, width)
        is_unknown &= ~is_clear
        is_something |= is_held
    for shape, T in explained:
        own = transform_points(inverse(T), voxels.middles)
        is_unknown &= ~shape.inflated(width / 2).contains(own)  # or boxes would reach into the answer
        is_unknown &= is_something | ~shape.inflated(RESERVE).contains(own)
    return voxels.boxes(is_unknown)


def unrecognised_boxes(
    room: Room,
    sights: Sequence[LineOfSight],
    explained: Sequence[tuple[Shape, Array]],
    refused: Sequence[tuple[Shape, Array]],
) -> Array:
    """Collect where something is in a room that nobody recognised, or may be.

    Of 137 recognised items in four scenes 13 touched one that was not. With all measured points, boxes
    touch 26 of them, among these all of the 13; with what looks from two places measured they touch 20,
    with 12. All four without which something unrecognised would fall are among both.

    Args:
        room: The room.
        sights: The rays of each picture of its place.
        explained: Shapes with their poses (4, 4) in the place's frame, inside of which all is explained.
        refused: Shapes of items that are not sure enough, with their poses.

    Returns:
        (N, 2, 3) m, lower and upper corners of boxes in the place's frame: voxels into which refused shapes
        reach, and those in which something was measured that nothing explains; of looks from several places
        by two of them, there or in a voxel beside.
    """
    voxels = RoomVoxels.of(room)
    is_filled = np.zeros(len(voxels.middles), dtype=bool)
    if sights:
        is_filled |= _agreed(_measured(voxels, sights, explained)).ravel()
    for shape, T in refused:
        own = transform_points(inverse(T), voxels.middles)
        is_filled |= voxels.is_room & shape.inflated(float(voxels.sides.max()) / 2).contains(own)
    return voxels.boxes(is_filled)


def _measured(
    voxels: RoomVoxels, sights: Sequence[LineOfSight], explained: Sequence[tuple[Shape, Array]]
) -> list[NDArray[np.bool_]]:
    """Grids (X, Y, Z) of where something was measured that nothing explains, by place of the camera."""
    seen: list[tuple[Array, NDArray[np.bool_]]] = []
    for sight in sights:
        points = sight.unexplained_points
        for shape, T in explained:
            points = points[~shape.contains(transform_points(inverse(T), points))]
        is_held = np.zeros(len(voxels.middles), dtype=bool)
        is_held[voxels.holding(points)] = True
        near = [held for eye, held in seen if np.linalg.norm(eye - sight.eye) < ASIDE]
        if near:
            near[0] |= is_held
        else:
            seen.append((sight.eye, is_held))
    return [held.reshape(voxels.counts) for _, held in seen]


def _agreed(seen: Sequence[NDArray[np.bool_]]) -> NDArray[np.bool_]:
    """Cells (X, Y, Z) of grids that another one has, too, there or beside; all of a single one."""
    if len(seen) == 1:
        return seen[0]
    n_near = sum(binary_dilation(each, _BESIDE).astype(np.intp) for each in seen)
    return np.asarray(np.any(seen, axis=0) & (n_near >= 2))


def whole_room(room: Room) -> Array:
    """Take a whole room as unknown.

    Args:
        room: The room.

    Returns:
        (N, 2, 3) m, lower and upper corners of boxes in the place's frame.
    """
    voxels = RoomVoxels.of(room)
    return voxels.boxes(voxels.is_room)


def merged_boxes(is_filled: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Merge the filled cells of a grid into boxes, greedily: from each first cell along x, then y, then z.

    Args:
        is_filled: (X, Y, Z) the cells.

    Returns:
        (N, 2, 3) first indices, and those after the last ones. Each filled cell is in one box, no other is.
    """
    n_x, n_y, n_z = is_filled.shape
    along_x, along_y = n_y * n_z, n_z
    left, found = bytearray(is_filled.tobytes()), []
    first = left.find(1)
    while first >= 0:
        x, y, z = first // along_x, first // along_y % n_y, first % n_z
        x1, y1, z1 = x + 1, y + 1, z + 1
        while x1 < n_x and left[first + (x1 - x) * along_x]:
            x1 += 1
        end = first + (x1 - x) * along_x
        while y1 < n_y and 0 not in left[first + (y1 - y) * along_y : end + (y1 - y) * along_y : along_x]:
            y1 += 1
        rows = [first + k * along_y for k in range(y1 - y)]
        while z1 < n_z and not any(0 in left[row + z1 - z : end + z1 - z : along_x] for row in rows):
            z1 += 1
        for i in range(first, end, along_x):
            for row in range(i, i + (y1 - y) * along_y, along_y):
                left[row : row + z1 - z] = bytes(z1 - z)
        found.append(((x, y, z), (x1, y1, z1)))
        first = left.find(1, first)
    return np.array(found, dtype=np.intp).reshape(-1, 2, 3)
