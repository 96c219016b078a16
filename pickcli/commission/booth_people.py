"""People who walk through the booth while the truck drives: drawn, or as a file states them.

They come in over the edge of the booth, and leave it on another side. Who gets near the truck turns round:
nobody walks into it, but nobody waits for it either.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from pickcli.driving.driving_area import DrivingArea
from pickcli.geometry import Array
from pickcli.seeds import derived_rng
from pickcli.watching.foreseen_contact import outline_distance
from pickcli.watching.watched_scene import Reflector, SunPatch, Walker

DRIVES = ("enter_pallet", "drive load", "drive delivery", "drive end")  # during which people come
SPEEDS = (0.5, 1.6)  # m/s
LATEST = 6.0  # s after the begin of a drive at which somebody comes, at most
OUTSIDE = 1.0  # m beyond the edge of the booth, where people begin and end
BESIDE = 0.35  # m that they keep from boxes
SHYNESS = 0.6  # m between a person's middle and the truck, where it turns round
TRIES = 200
DECIMALS = 3
HEIGHTS = (1.6, 1.95)  # m


@dataclass(frozen=True)
class TurningWalker(Walker):
    """A person who turns round before the truck, and goes back.

    Attributes:
        turned: s at which the person turned round, once it did.
    """

    turned: list[float] = field(default_factory=list, compare=False)

    def walked(self, time: float) -> float:
        """Return how far the person is along the route.

        Args:
            time: s.

        Returns:
            m; less again after the person turned round.
        """
        if not self.turned or time <= self.turned[0]:
            return super().walked(time)
        return max(0.0, super().walked(self.turned[0]) - self.speed * (time - self.turned[0]))

    def heading(self, time: float) -> float:
        """Return where the person looks.

        Args:
            time: s.

        Returns:
            rad to the x of the floor.
        """
        ahead = super().heading(time)
        return ahead + np.pi if self.turned and time > self.turned[0] else ahead

    def avoid(self, time: float, area: DrivingArea, truck: Array) -> None:
        """Turn round if the truck is near.

        Args:
            time: s.
            area: What tells the outline of the truck.
            truck: (3,) m, m, rad: where it is.
        """
        near = outline_distance(area.truck, truck[None], self.place(time)[None])[0]
        if not self.turned and near < SHYNESS:
            self.turned.append(time)


class BoothPeople(Protocol):
    """Who is in the booth."""

    def during(self, drive: str, t_start: float, area: DrivingArea, seed: int) -> tuple[TurningWalker, ...]:
        """Return who may come during a drive.

        Args:
            drive: Name of the drive.
            t_start: s of the trial at its start.
            area: Where it is.
            seed: Seed of the trial.

        Returns:
            The people, on the clock of the drive.
        """

    @property
    def surroundings(self) -> tuple[tuple[Reflector, ...], tuple[SunPatch, ...]]:
        """Reflectors that are no vests, and where the sun shines."""


@dataclass(frozen=True)
class DrawnPeople:
    """People drawn by the seed: each comes in one of the drives, once.

    Attributes:
        number: How many.
    """

    number: int

    def during(self, drive: str, t_start: float, area: DrivingArea, seed: int) -> tuple[TurningWalker, ...]:
        """Draw who comes during a drive; who has no free way through the booth does not come.

        Args:
            drive: Name of the drive.
            t_start: s of the trial at its start.
            area: Where it is.
            seed: Seed of the trial.

        Returns:
            The people, on the clock of the drive.
        """
        found = []
        for k in range(self.number):
            rng = derived_rng("booth people", seed, k)
            if DRIVES[int(rng.integers(len(DRIVES)))] == drive:
                found += _drawn(f"person {k + 1}", area, rng)
        return tuple(found)

    @property
    def surroundings(self) -> tuple[tuple[Reflector, ...], tuple[SunPatch, ...]]:
        """Neither reflectors nor sun."""
        return (), ()


@dataclass(frozen=True)
class StatedPeople:
    """People of a watched scene, whose clock is that of the trial.

    Attributes:
        walkers: The people.
        reflectors: What reflects the flash beside vests.
        sun: Where the sun shines.
    """

    walkers: tuple[Walker, ...]
    reflectors: tuple[Reflector, ...] = ()
    sun: tuple[SunPatch, ...] = ()

    def during(self, drive: str, t_start: float, area: DrivingArea, seed: int) -> tuple[TurningWalker, ...]:
        """Return all people, on the clock of a drive.

        Args:
            drive: Name of the drive.
            t_start: s of the trial at its start.
            area: Where it is.
            seed: Seed of the trial.

        Returns:
            The people.
        """
        return tuple(
            TurningWalker(each.name, each.route, each.speed, each.start - t_start, each.height, each.has_vest)
            for each in self.walkers
        )

    @property
    def surroundings(self) -> tuple[tuple[Reflector, ...], tuple[SunPatch, ...]]:
        """Reflectors and sun as they are stated."""
        return self.reflectors, self.sun


def without_truck(walkers: Sequence[TurningWalker], area: DrivingArea) -> tuple[TurningWalker, ...]:
    """Leave out who stands where the truck is as a drive begins.

    Args:
        walkers: People on the clock of the drive.
        area: Where it is, with the truck at its start.

    Returns:
        All others.
    """
    return tuple(
        each
        for each in walkers
        if outline_distance(area.truck, area.start[None], each.place(0.0)[None])[0] > SHYNESS
    )


def _drawn(name: str, area: DrivingArea, rng: np.random.Generator) -> list[TurningWalker]:
    """A person with a straight way from one side of the booth over another; none if none is free."""
    low, high = np.array(area.low), np.array(area.high)
    for _ in range(TRIES):
        ends = [_beyond(low, high, side, rng) for side in rng.permutation(4)[:2].tolist()]
        way = np.linspace(ends[0], ends[1], 60)
        if all(float(box.distance(way).min()) > BESIDE for box in area.boxes):
            route = tuple((round(float(x), DECIMALS), round(float(y), DECIMALS)) for x, y in ends)
            speed, start, height = (
                round(float(rng.uniform(*ends)), DECIMALS) for ends in (SPEEDS, (0.0, LATEST), HEIGHTS)
            )
            return [TurningWalker(name, route, speed, start, height)]
    return []


def _beyond(low: Array, high: Array, side: int, rng: np.random.Generator) -> Array:
    """(2,) m: a place beyond one side of the booth: of x for even sides."""
    place, axis = rng.uniform(low, high), side // 2
    place[axis] = low[axis] - OUTSIDE if side % 2 == 0 else high[axis] + OUTSIDE
    return place
