"""What stands around the robot: pod, bins, tote, obstacles."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.pod_tolerance import UNMOVED, Displacement
from pickcli.cell.shapes import Body
from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class Bin:
    """One bin of the pod.

    The bin frame: origin at the middle of the mouth on the top of the bottom lip, on the pod's front
    face; +x into the bin, +y left as the robot sees it, +z up.
    """

    name: str  # bin_A .. bin_L
    T_pod_bin: Array  # (4, 4)
    mouth_width: float  # m, clear opening along y
    mouth_height: float  # m, from the lip's top to the hanging lip above
    y_range: tuple[
        float, float
    ]  # m, clear inside behind the mouth, bin frame (behind a post wider than the mouth)
    depth: float  # m, front face to back wall
    floor_front: float  # z of the floor just behind the lip, bin frame, m (negative)
    floor_back: float  # z of the flat back part of the floor, m (negative)
    slope_from: float  # x where floor and ceiling begin to drop, behind the lip, m
    floor_flat_from: float  # x where the slope ends, m
    ceiling_front: float  # z of the ceiling just behind the hanging lip, m
    ceiling_back: float  # z of the ceiling at the back, m
    floor: tuple[str, ...] = ()  # names of the pod's bodies that carry what lies in this bin

    @property
    def volume(self) -> float:
        """Volume of the clear inside in m^3, as high everywhere as over the flat part of the floor."""
        width, height = self.y_range[1] - self.y_range[0], self.ceiling_back - self.floor_back
        return self.depth * width * height

    @property
    def clear_size(self) -> Array:
        """(3,) depth, width and greatest height of the clear inside, m."""
        return np.array([self.depth, self.y_range[1] - self.y_range[0], self.ceiling_front - self.floor_back])

    def too_small_for(self, extents: Array) -> str:
        """Why something does not fit inside, whichever way it is turned.

        Args:
            extents: (3,) m, its size along its own axes.

        Returns:
            Both sizes in mm where its narrowest side is wider than the narrowest of the bin, or it is longer
            than the bin's diagonal. "" where it may fit; it may still find no room.
        """
        size = self.clear_size
        if extents.min() <= size.min() and extents.max() <= np.linalg.norm(size):
            return ""
        own, clear = (" x ".join(f"{1e3 * side:.0f}" for side in sides) for sides in (extents, size))
        return f"{own} mm, the bin {clear} mm inside"

    def floor_at(self, x: Array | float) -> Array:
        """Height of the floor in m in the bin frame, x m behind the front face (under the lip: as behind)."""
        ends, heights = (self.slope_from, self.floor_flat_from), (self.floor_front, self.floor_back)
        return np.asarray(np.interp(x, ends, heights))

    def ceiling_at(self, x: Array | float) -> Array:
        """Height of the ceiling in m in the bin frame, x m behind the front face (at the lip: as behind)."""
        ends, heights = (self.slope_from, self.floor_flat_from), (self.ceiling_front, self.ceiling_back)
        return np.asarray(np.interp(x, ends, heights))

    def rest(self, x: Array, half: Array) -> tuple[Array, Array]:
        """Height of the middle of a base that lies on the floor, in m in the bin frame, and its pitch in rad.

        x, half: middle and half length of the base along x, m. The floor is hollow, so a base touches it
        with its two ends.
        """
        front, back = self.floor_at(x - half), self.floor_at(x + half)
        return (front + back) / 2, np.arctan2(front - back, 2 * half)


@dataclass(frozen=True, eq=False)
class Pod:
    """The shelf. Its frame is the pod frame: front face at x = 0, +x into the shelf, z = 0 on the floor."""

    bodies: tuple[Body, ...]  # boxes in the pod frame
    bins: dict[str, Bin]
    groups: dict[str, tuple[str, ...]]  # bounding groups: name -> body names (speeds up collision tests)
    displacement: Displacement = UNMOVED  # how far it may stand from its place

    def swept(self) -> Pod:
        """The pod with each body grown to a box that holds it wherever the pod stands in its bounds."""
        return replace(self, bodies=tuple(self.displacement.swept(body) for body in self.bodies))

    def bin_of_point(self, p_pod: Array) -> str | None:
        """Name of the bin whose inside holds a point (3,) of the pod frame, or None."""
        for name, cell_bin in self.bins.items():
            x, y, z = p_pod - cell_bin.T_pod_bin[:3, 3]
            if (
                0.0 <= x <= cell_bin.depth
                and cell_bin.y_range[0] <= y <= cell_bin.y_range[1]
                and cell_bin.floor_back <= z <= cell_bin.ceiling_front
            ):
                return name
        return None


@dataclass(frozen=True, eq=False)
class Tote:
    """The tote: an open box. Its frame sits at the centre of the inner floor, axes of the world."""

    T_world_tote: Array  # (4, 4)
    inner: tuple[float, float, float]  # m, clear inside x, y and height of the rim over the inner floor
    bodies: tuple[Body, ...]  # in the world frame


@dataclass(frozen=True, eq=False)
class Obstacles:
    """Everything else that stands still: boxes in the world frame."""

    bodies: tuple[Body, ...]
