"""Places that hold items: pose, free room and access.

Bins of a shelf, totes and table tops are all places. Planning uses only the properties defined here and need
not know the kind of a place.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.geometry import Array, pose


@dataclass(frozen=True, eq=False)
class Access:
    """The straight access into a place through a rectangular mouth.

    Attributes:
        T_place_mouth: Pose (4, 4) of the mouth in the place's frame: origin in the middle of the rectangle,
            x into the place, y along its width, z along its height.
        width: m, clear width along the mouth's y.
        height: m, clear height along the mouth's z.
    """

    T_place_mouth: Array
    width: float
    height: float

    @classmethod
    def from_front(cls, width: float, height: float) -> Access:
        """Access along +x through a mouth at x = 0, whose lower edge has the place's origin in its middle.

        Args:
            width: m.
            height: m.

        Returns:
            The access.
        """
        return cls(pose((0.0, 0.0, height / 2)), width, height)

    @classmethod
    def from_above(cls, x_size: float, y_size: float, rim: float) -> Access:
        """Access along -z through a mouth above the place's origin.

        Args:
            x_size: m.
            y_size: m.
            rim: m from the origin up to the mouth.

        Returns:
            The access.
        """
        down = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
        return cls(pose((0.0, 0.0, rim), R=down), y_size, x_size)

    @property
    def direction(self) -> Array:
        """(3,) unit vector into the place, in its frame."""
        return np.asarray(self.T_place_mouth[:3, 0])

    @cached_property
    def is_from_above(self) -> bool:
        """Whether the access is downwards, so that items may rise above the mouth."""
        return bool(self.direction[2] < -0.5)


@dataclass(frozen=True, eq=False)
class Room:
    """Free room of a place, in its frame: upright walls, and a floor and a ceiling that may slope along x.

    Floor and ceiling drop linearly between ``slope_from`` and ``floor_flat_from``, and are level elsewhere.

    Attributes:
        x_range: m, clear inside along x.
        y_range: m, clear inside along y (behind the posts of a bin it is wider than the mouth).
        floor_front: z in m of the floor in front of the slope.
        floor_back: z in m of the floor behind the slope.
        ceiling_front: z in m of the ceiling in front of the slope; of places open above, z of the rim.
        ceiling_back: z in m of the ceiling behind the slope.
        slope_from: x in m at which floor and ceiling begin to drop.
        floor_flat_from: x in m at which the slope ends.
    """

    x_range: tuple[float, float]
    y_range: tuple[float, float]
    floor_front: float
    floor_back: float
    ceiling_front: float
    ceiling_back: float
    slope_from: float
    floor_flat_from: float

    @classmethod
    def box(cls, x_size: float, y_size: float, height: float) -> Room:
        """Return a room with a level floor and the place's origin in the middle of it.

        Args:
            x_size: m.
            y_size: m.
            height: m.

        Returns:
            The room.
        """
        x, y = x_size / 2, y_size / 2
        return cls((-x, x), (-y, y), 0.0, 0.0, height, height, -x, x)

    @property
    def depth(self) -> float:
        """Depth along x, m."""
        return self.x_range[1] - self.x_range[0]

    @property
    def low(self) -> Array:
        """Lower corner (3,) of the box around the room."""
        return np.array([self.x_range[0], self.y_range[0], self.floor_back])

    @property
    def high(self) -> Array:
        """Upper corner (3,) of the box around the room."""
        return np.array([self.x_range[1], self.y_range[1], self.ceiling_front])

    @property
    def size(self) -> Array:
        """Size (3,) in m of the box around the room."""
        return np.asarray(self.high - self.low)

    @property
    def volume(self) -> float:
        """Volume in m^3, with the height over the flat part of the floor."""
        width, height = self.y_range[1] - self.y_range[0], self.ceiling_back - self.floor_back
        return self.depth * width * height

    def too_small_for(self, extents: Array) -> str:
        """Say why a body cannot fit inside in any orientation.

        Args:
            extents: (3,) m, size of the body along its own axes.

        Returns:
            Both sizes in mm if the narrowest side is wider than the narrowest of the room, or the longest
            longer than the room's diagonal; else "". A body may still not fit.
        """
        if extents.min() <= self.size.min() and extents.max() <= np.linalg.norm(self.size):
            return ""
        own, clear = (" x ".join(f"{1e3 * side:.0f}" for side in sides) for sides in (extents, self.size))
        return f"{own} mm, the place {clear} mm inside"

    def floor_at(self, x: Array | float) -> Array:
        """Compute the height of the floor.

        Args:
            x: m.

        Returns:
            m.
        """
        ends, heights = (self.slope_from, self.floor_flat_from), (self.floor_front, self.floor_back)
        return np.asarray(np.interp(x, ends, heights))

    def ceiling_at(self, x: Array | float) -> Array:
        """Compute the height of the ceiling.

        Args:
            x: m.

        Returns:
            m.
        """
        ends, heights = (self.slope_from, self.floor_flat_from), (self.ceiling_front, self.ceiling_back)
        return np.asarray(np.interp(x, ends, heights))

    def contains(self, p: Array, above: float = 0.0) -> bool:
        """Whether a point is between walls, floor and ceiling.

        Args:
            p: (3,) m in the place's frame.
            above: m above the ceiling that count as inside.

        Returns:
            True if it is inside.
        """
        x, y, z = p
        in_plan = self.x_range[0] <= x <= self.x_range[1] and self.y_range[0] <= y <= self.y_range[1]
        return bool(in_plan and self.floor_at(x) <= z <= self.ceiling_at(x) + above)

    def rest(self, x: Array, half: Array) -> tuple[Array, Array]:
        """Compute how a base rests on the floor; the floor is concave, so it rests on its two ends.

        Args:
            x: Middle of the base along x, m.
            half: Half of the base's length along x, m.

        Returns:
            Height of its middle in m, and its pitch in rad.
        """
        front, back = self.floor_at(x - half), self.floor_at(x + half)
        return (front + back) / 2, np.arctan2(front - back, 2 * half)


@dataclass(frozen=True, eq=False)
class Place:
    """One place that holds items: a bin of a shelf, a box, the top of a table.

    Frame of a place with access from the front: origin in the middle of the mouth on top of the bottom lip,
    +x into the place, +y left as seen by the robot, +z up. Frame of a place with access from above: origin in
    the middle of the inner floor, +z up.

    Attributes:
        name: Name by which items state their location: bin_A .. bin_L, tote.
        carrier: Name of the carrier that it is part of.
        T_carrier_place: Pose (4, 4) of the place's frame in the carrier's.
        access: The access into it.
        room: Its free room.
        support: Names of the bodies that support its items.
    """

    name: str
    carrier: str
    T_carrier_place: Array
    access: Access
    room: Room
    support: tuple[str, ...] = ()

    @property
    def T_place_entry(self) -> Array:
        """Pose (4, 4) of the access frame: the mouth's orientation, with the origin on its lower edge.

        Of a bin it equals the bin's frame; of a tote it is the frame of a bin that lies on its back.
        """
        return np.asarray(self.access.T_place_mouth @ pose((0.0, 0.0, -self.access.height / 2)))

    @property
    def is_open_box(self) -> bool:
        """Whether it is a box open above: an item released over it may drop a little and stays inside."""
        has_walls = self.access.T_place_mouth[2, 3] > self.room.floor_back
        return self.access.is_from_above and bool(has_walls)

    def holds(self, p: Array, above: float = 0.0) -> bool:
        """Whether a point is inside the box around the room.

        Args:
            p: (3,) m in the place's frame.
            above: m above the rim that count as inside if the access is from above.

        Returns:
            True if it is inside.
        """
        high = self.room.high
        high[2] += above if self.access.is_from_above else 0.0
        return bool((self.room.low <= p).all() and (p <= high).all())
