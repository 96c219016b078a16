"""What is to be seen from the truck: people who walk, boxes of some height, reflectors, sun."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

import numpy as np

from pickcli.driving.driving_area import DrivingArea
from pickcli.geometry import Array

STRIDE = 1.4  # m of two steps
SWING = 0.22  # m that a foot is before or behind the body, at a walk
APART = 0.09  # m of a leg beside the middle of the body
LEG = 0.06  # m, radius


class ReflectorKind(StrEnum):
    """Kinds of what reflects the flash beside vests."""

    SIGN = "sign"  # retroreflective all over
    TAPE = "tape"  # a retroreflective stripe on a wall, a box or the floor
    POST = "post"  # of polished metal, round


@dataclass(frozen=True)
class Walker:
    """A person.

    Attributes:
        name: Name in reports.
        route: Places one after the other, m.
        speed: m/s; 0 for someone who stands at the first place.
        start: s at which the person begins to walk; before and after the person stands.
        height: m of the whole person.
        has_vest: Whether the person wears a vest.
    """

    name: str
    route: tuple[tuple[float, float], ...]
    speed: float
    start: float = 0.0
    height: float = 1.75
    has_vest: bool = True

    @cached_property
    def _knots(self) -> Array:
        """(P,) m of way up to each place."""
        places = np.array(self.route)
        return np.concatenate([[0.0], np.hypot(*np.diff(places, axis=0).T).cumsum()])

    def walked(self, time: float) -> float:
        """Return how far the person has walked.

        Args:
            time: s.

        Returns:
            m.
        """
        return float(np.clip(self.speed * (time - self.start), 0.0, self._knots[-1]))

    def place(self, time: float) -> Array:
        """Return where the person is.

        Args:
            time: s.

        Returns:
            (2,) m.
        """
        places, way = np.array(self.route), self.walked(time)
        return np.array(
            [np.interp(way, self._knots, places[:, 0]), np.interp(way, self._knots, places[:, 1])]
        )

    def heading(self, time: float) -> float:
        """Return where the person looks.

        Args:
            time: s.

        Returns:
            rad to the x of the floor.
        """
        if len(self.route) < 2:
            return 0.0
        k = min(int(np.searchsorted(self._knots, self.walked(time), side="right")), len(self.route) - 1)
        x, y = np.subtract(self.route[k], self.route[k - 1])
        return float(np.arctan2(y, x))

    def velocity(self, time: float) -> Array:
        """Return how fast and where the person walks.

        Args:
            time: s.

        Returns:
            (2,) m/s.
        """
        is_walking = self.start <= time and self.walked(time) < self._knots[-1]
        heading = self.heading(time)
        return self.speed * is_walking * np.array([np.cos(heading), np.sin(heading)])

    def legs(self, time: float) -> Array:
        """Return where the legs are.

        Args:
            time: s.

        Returns:
            (2, 3) m: middles and radii.
        """
        heading, way = self.heading(time), self.walked(time)
        swing = SWING * min(self.speed, 1.0) * np.sin(2 * np.pi * way / STRIDE)
        ahead, beside = (
            np.array([np.cos(heading), np.sin(heading)]),
            np.array([-np.sin(heading), np.cos(heading)]),
        )
        middles = self.place(time) + np.array(
            [swing * ahead + APART * beside, -swing * ahead - APART * beside]
        )
        return np.column_stack([middles, np.full(2, LEG)])


@dataclass(frozen=True)
class Reflector:
    """Something that reflects the flash and is no vest.

    Attributes:
        kind: Its kind.
        centre: (3,) m: its middle.
        size: m along the floor and upwards; of tape on the floor, its length and width.
        yaw: rad, where its face looks; of a post without meaning.
        is_flat: Whether it lies on the floor.
    """

    kind: ReflectorKind
    centre: tuple[float, float, float]
    size: tuple[float, float]
    yaw: float = 0.0
    is_flat: bool = False


@dataclass(frozen=True)
class SunPatch:
    """A rectangle of the floor where the sun shines, and on all above it.

    Attributes:
        centre: (2,) m.
        size: (2,) m along its own x and y.
        yaw: rad.
        strength: How many times the light indoors.
    """

    centre: tuple[float, float]
    size: tuple[float, float]
    yaw: float
    strength: float


@dataclass(frozen=True, eq=False)
class WatchedScene:
    """An area with all that is to be seen in it.

    Attributes:
        area: Walls, boxes and the truck.
        box_heights: m of each box of the area.
        walkers: The people.
        reflectors: What reflects and is no vest.
        sun: Where the sun shines.
        duration: s that are watched, at most.
    """

    area: DrivingArea
    box_heights: tuple[float, ...]
    walkers: tuple[Walker, ...]
    reflectors: tuple[Reflector, ...] = ()
    sun: tuple[SunPatch, ...] = ()
    duration: float = 60.0

    def segments(self, above: float) -> Array:
        """Return what walls and boxes look like in a plane.

        Args:
            above: m of the plane above the floor.

        Returns:
            (S, 2, 2) m: ends of their sides.
        """
        low, high = self.area.low, self.area.high
        rectangles = [np.array([low, (high[0], low[1]), high, (low[0], high[1])])]
        rectangles += [
            box.corners
            for box, height in zip(self.area.boxes, self.box_heights, strict=True)
            if height > above
        ]
        return np.concatenate([np.stack([each, np.roll(each, -1, axis=0)], axis=1) for each in rectangles])

    def discs(self, time: float) -> Array:
        """Return what is round near the floor.

        Args:
            time: s.

        Returns:
            (D, 3) m: middles and radii of legs and posts.
        """
        posts = [
            (*each.centre[:2], each.size[0] / 2)
            for each in self.reflectors
            if each.kind is ReflectorKind.POST
        ]
        return np.concatenate([np.array(posts).reshape(-1, 3), *(each.legs(time) for each in self.walkers)])
