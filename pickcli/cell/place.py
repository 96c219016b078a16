"""Places that hold items: where one is, how much room it has, and which way leads into it.

A bin of a shelf, a tote and the top of a table are places; what makes them differ is stated here and asked
for by its meaning, so that what plans a pick need not know which of them it is in.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.geometry import Array, pose


@dataclass(frozen=True, eq=False)
class Access:
    """The one way into a place: straight through a rectangular mouth.

    Attributes:
        T_place_mouth: Pose (4, 4) of the mouth in the place's frame: origin in the middle of the rectangle,
            x into the place, y along its width, z along its height.
        width: m, clear opening along the mouth's y.
        height: m, clear opening along the mouth's z.
    """

    T_place_mouth: Array
    width: float
    height: float

    @classmethod
    def from_front(cls, width: float, height: float) -> Access:
        """The way along +x, through a mouth at x = 0; the middle of its lower edge is the place's origin.

        Args:
            width: m.
            height: m.

        Returns:
            The access.
        """
        return cls(pose((0.0, 0.0, height / 2)), width, height)

    @classmethod
    def from_above(cls, x_size: float, y_size: float, rim: float) -> Access:
        """The way along -z, through a mouth above the place's origin.

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
        """Whether the way in leads down, so that what lies in the place may rise above its mouth."""
        return bool(self.direction[2] < -0.5)


@dataclass(frozen=True, eq=False)
class Room:
    """The free room of a place, in its frame: upright walls, and a floor and a ceiling that may drop along x.

    Both drop evenly between ``slope_from`` and ``floor_flat_from``, and run level before and behind.

    Attributes:
        x_range: m, clear inside along x.
        y_range: m, clear inside along y (of a bin behind a post wider than the mouth).
        floor_front: z in m of the floor in front of the slope.
        floor_back: z in m of the floor behind it.
        ceiling_front: z in m of the ceiling in front of the slope; of what is open above, of the rim.
        ceiling_back: z in m of the ceiling behind it.
        slope_from: x in m where floor and ceiling begin to drop.
        floor_flat_from: x in m where the slope ends.
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
        """A room with a level floor, around the origin of the place in its middle.

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
        """Volume in m^3, as high everywhere as over the flat part of the floor."""
        width, height = self.y_range[1] - self.y_range[0], self.ceiling_back - self.floor_back
        return self.depth * width * height

    def too_small_for(self, extents: Array) -> str:
        """Why something does not fit inside, whichever way it is turned.

        Args:
            extents: (3,) m, its size along its own axes.

        Returns:
            Both sizes in mm where its narrowest side is wider than the narrowest of the room, or it is longer
            than the room's diagonal. "" where it may fit; it may still find no room.
        """
        if extents.min() <= self.size.min() and extents.max() <= np.linalg.norm(self.size):
            return ""
        own, clear = (" x ".join(f"{1e3 * side:.0f}" for side in sides) for sides in (extents, self.size))
        return f"{own} mm, the place {clear} mm inside"

    def floor_at(self, x: Array | float) -> Array:
        """Height of the floor.

        Args:
            x: m.

        Returns:
            m.
        """
        ends, heights = (self.slope_from, self.floor_flat_from), (self.floor_front, self.floor_back)
        return np.asarray(np.interp(x, ends, heights))

    def ceiling_at(self, x: Array | float) -> Array:
        """Height of the ceiling.

        Args:
            x: m.

        Returns:
            m.
        """
        ends, heights = (self.slope_from, self.floor_flat_from), (self.ceiling_front, self.ceiling_back)
        return np.asarray(np.interp(x, ends, heights))

    def rest(self, x: Array, half: Array) -> tuple[Array, Array]:
        """How a base lies on the floor. The floor is hollow, so a base touches it with its two ends.

        Args:
            x: Middle of the base along x, m.
            half: Half its length along x, m.

        Returns:
            Height of its middle in m, and its pitch in rad.
        """
        front, back = self.floor_at(x - half), self.floor_at(x + half)
        return (front + back) / 2, np.arctan2(front - back, 2 * half)


@dataclass(frozen=True, eq=False)
class Place:
    """One place that holds items: a bin of a shelf, a box, the top of a table.

    The frame of a place that is reached from the front: origin at the middle of the mouth on the top of the
    bottom lip; +x into the place, +y left as the robot sees it, +z up. That of one that is reached from
    above: origin in the middle of the inner floor, +z up.

    Attributes:
        name: As items name their location: bin_A .. bin_L, tote.
        carrier: Name of the carrier that it is part of, and moves with.
        T_carrier_place: Pose (4, 4) of its frame in that of the carrier.
        access: The way into it.
        room: Its free room.
        support: Names of the bodies that carry what lies in it.
    """

    name: str
    carrier: str
    T_carrier_place: Array
    access: Access
    room: Room
    support: tuple[str, ...] = ()

    @property
    def T_place_entry(self) -> Array:
        """Pose (4, 4) of the frame of the way in: of the mouth, but its origin on the lower edge.

        A bin's is the frame of the bin itself; a tote has it as if it were a bin that lies on its back.
        """
        return np.asarray(self.access.T_place_mouth @ pose((0.0, 0.0, -self.access.height / 2)))

    @property
    def is_open_box(self) -> bool:
        """Whether it is open above, between walls: what is let go over it may drop a little, and stays."""
        has_walls = self.access.T_place_mouth[2, 3] > self.room.floor_back
        return self.access.is_from_above and bool(has_walls)

    def holds(self, p: Array, above: float = 0.0) -> bool:
        """Whether a point is in the box around the room.

        Args:
            p: (3,) m in the place's frame.
            above: m over the rim that count as well, where the way in leads down.

        Returns:
            True if it is.
        """
        high = self.room.high
        high[2] += above if self.access.is_from_above else 0.0
        return bool((self.room.low <= p).all() and (p <= high).all())
