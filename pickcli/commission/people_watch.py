"""A drive of a commission that is watched for people: it brakes for them, and tells whom it met."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from pickcli.commission.booth_people import BoothPeople, without_truck
from pickcli.driving.drive_tracking import PERIOD, TrackingController
from pickcli.driving.driving_area import DrivingArea
from pickcli.geometry import Array
from pickcli.seeds import derived_seed
from pickcli.watching.drive_watch import DriveWatch, Guards
from pickcli.watching.watch_file import Watch
from pickcli.watching.watched_scene import WatchedScene

MOST_WAIT = 60.0  # s without getting on, after which a drive that is braked is given up
SHOWN_EVERY = 10  # periods between places of people that are kept


@dataclass(frozen=True, eq=False)
class BoothWatch:
    """How drives of a commission are watched.

    Attributes:
        people: Who is in the booth.
        watch: Sensors, fields and brake of the truck.
        guards: Which guards brake it.
    """

    people: BoothPeople
    watch: Watch
    guards: Guards


@dataclass(frozen=True, eq=False)
class WatchedPerson:
    """Where a person truly was during a drive.

    Attributes:
        name: The person.
        height: m.
        has_vest: Whether it wore a vest.
        places: (N, 2) m, each ``SHOWN_EVERY`` periods of the drive.
    """

    name: str
    height: float
    has_vest: bool
    places: Array


@dataclass(frozen=True, eq=False)
class WatchedOutcome:
    """What came of the watch of one drive.

    Attributes:
        braked: s for which the truck was braked or held.
        n_requests: Number of brake requests.
        touched: Whom the moving truck touched: by its own motion.
        walked_in: Who touched the moving truck by their own.
        n_seen: Number of people whose vests were recognised.
        n_false: Number of confirmed tracks that were nobody.
        has_given_up: Whether the drive ended where the truck was braked.
        people: Where they were.
    """

    braked: float
    n_requests: int
    touched: tuple[str, ...]
    walked_in: tuple[str, ...]
    n_seen: int
    n_false: int
    has_given_up: bool
    people: tuple[WatchedPerson, ...]

    @property
    def figures(self) -> dict[str, Any]:
        """Plain values by name."""
        return {
            "people": len(self.people), "braked_s": self.braked, "brake_requests": self.n_requests,
            "touched": list(self.touched), "walked_in": list(self.walked_in), "vests_seen": self.n_seen,
            "false_tracks": self.n_false,
        }  # fmt: skip


class PeopleWatch:
    """Oversees one drive: people turn round before the truck, and it brakes for them.

    Args:
        booth: How it is watched.
        drive: Name of the drive.
        area: Where it is, with the truck at its start.
        t_start: s of the trial at its start.
        seed: Seed of the trial.
        number: Number of the drive in the trial.
    """

    def __init__(
        self, booth: BoothWatch, drive: str, area: DrivingArea, t_start: float, seed: int, number: int
    ) -> None:
        self._area = area
        self._walkers = without_truck(booth.people.during(drive, t_start, area, seed), area)
        reflectors, sun = booth.people.surroundings
        heights = tuple(box.height for box in area.boxes)
        scene = WatchedScene(area, heights, self._walkers, reflectors, sun, np.inf)
        watched = derived_seed("watched commission", seed, number)
        self._watch = DriveWatch(scene, area, booth.watch, booth.guards, watched, MOST_WAIT)

    @property
    def has_given_up(self) -> bool:
        """Whether the drive ends where the truck was braked for ``MOST_WAIT``."""
        return self._watch.has_given_up

    def brakes(self, true: Array, believed: Array, controller: TrackingController) -> bool:
        """Let people turn round before the truck, and tell whether it brakes for them.

        Args:
            true: (3,) m, m, rad: where the truck truly is.
            believed: (3,) m, m, rad: where it believes to be.
            controller: How it moves.

        Returns:
            Whether it brakes, and stands then.
        """
        for walker in self._walkers:
            walker.avoid(self._watch.time, self._area, true)
        return self._watch.brakes(true, believed, controller)

    def outcome(self) -> WatchedOutcome:
        """Return what came of it.

        Returns:
            The outcome.
        """
        watch, touches = self._watch, self._watch.truth.touches()
        times = np.arange(0, len(watch.is_braked), SHOWN_EVERY) * PERIOD
        people = tuple(
            WatchedPerson(
                each.name, each.height, each.has_vest,
                np.array([each.place(float(t)) for t in times]).reshape(-1, 2),
            )
            for each in self._walkers
        )  # fmt: skip
        return WatchedOutcome(
            PERIOD * sum(watch.is_braked),
            len(watch.requests),
            tuple(each.name for each in touches if each.is_by_truck),
            tuple(each.name for each in touches if not each.is_by_truck),
            sum(each.seen_time is not None for each in watch.truth.people()),
            watch.truth.n_false,
            watch.has_given_up,
            people,
        )
