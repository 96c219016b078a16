"""What came of a watched drive: who was seen when, which brakes were requested, whom the truck touched."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array
from pickcli.watching.protective_field import ProtectiveField
from pickcli.watching.watched_scene import WatchedScene

DECIMALS = 4


@dataclass(frozen=True)
class PersonReport:
    """One person, as the vest cameras saw them.

    Attributes:
        name: The person.
        in_view_time: s at which the cameras first saw most of the vest; None if never.
        seen_time: s at which the track was confirmed, with the delay of the pair; None if never.
        seen_distance: m from the cameras then.
        probability: Of being a person, at last; None without a track.
        n_in_view: Number of picture sets, of each fourth one, in which most of the vest was in view.
        n_found: In how many of them it was found.
        position_error: m, root mean square while confirmed; None without.
        velocity_error: m/s, likewise.
    """

    name: str
    in_view_time: float | None
    seen_time: float | None
    seen_distance: float | None
    probability: float | None
    n_in_view: int
    n_found: int
    position_error: float | None
    velocity_error: float | None


@dataclass(frozen=True)
class RequestReport:
    """One brake request.

    Attributes:
        time: s.
        by: ``scanner`` or ``vests``.
        name: The nearest person that is a reason for it; None if there is none.
        speed: m/s of the steered wheel then.
        steering: rad.
        stopping: m of its travel until the truck would rest, with the reaction of the brake.
        free: m of travel until it would touch someone who stands still; None if nobody is ahead.
        delay: s since there was first a reason, at most; None if there was none.
        field: The field that was watched, of the scan that led to it if the scanner made it; None if no
            sensor looked where the truck drove.
    """

    time: float
    by: str
    name: str | None
    speed: float
    steering: float
    stopping: float
    free: float | None
    delay: float | None
    field: ProtectiveField | None

    def plain(self) -> dict[str, Any]:
        """Return plain values, of the field what it is for."""
        rest = {each.name: getattr(self, each.name) for each in fields(self) if each.name != "field"}
        of_field = {
            f"field_{name}": None if self.field is None else getattr(self.field, name)
            for name in ("speed", "steering")
        }
        return _rounded_values(rest | of_field)


@dataclass(frozen=True)
class TouchReport:
    """A person and the moving truck in contact.

    Attributes:
        time: s.
        name: The person.
        speed: m/s of the steered wheel.
        is_by_truck: Whether the truck's side that touches moves towards the person; else the person walked
            into it.
        is_avoidable: Whether a truck that begins its delay when a sensor could first see the person would
            have stopped in time.
    """

    time: float
    name: str
    speed: float
    is_by_truck: bool
    is_avoidable: bool


@dataclass(frozen=True, eq=False)
class WatchedDrive:
    """A drive through a watched scene.

    Attributes:
        scene: The scene.
        poses: (T, 3) m, m, rad: the truck, each ``PERIOD``.
        speeds: (T,) m/s of the steered wheel.
        is_braked: (T,) whether a guard braked it.
        arrived: Whether it reached its goal in time.
        unwatched: m of travel backwards, where no sensor looks.
        people: One report for each person in a vest.
        requests: In the order of time.
        touches: Likewise.
        n_false: Number of confirmed tracks that were nobody.
        n_pictures: Number of picture sets.
        tracks: By number of a track, its places (N, 3): s, m, m.
    """

    scene: WatchedScene
    poses: Array
    speeds: Array
    is_braked: NDArray[np.bool_]
    arrived: bool
    unwatched: float
    people: tuple[PersonReport, ...]
    requests: tuple[RequestReport, ...]
    touches: tuple[TouchReport, ...]
    n_false: int
    n_pictures: int
    tracks: dict[int, Array]

    def figures(self, period: float) -> dict[str, Any]:
        """Return the figures that people ask for.

        Args:
            period: s between two poses.

        Returns:
            Plain values.
        """
        return {
            "duration": _rounded(period * (len(self.poses) - 1)),
            "arrived": self.arrived,
            "braked": _rounded(period * float(np.count_nonzero(self.is_braked))),
            "unwatched_travel": _rounded(self.unwatched),
            "pictures": self.n_pictures,
            "false_tracks": self.n_false,
            "people": [_plain(each) for each in self.people],
            "requests": [each.plain() for each in self.requests],
            "touches": [_plain(each) for each in self.touches],
        }


def _plain(report: PersonReport | TouchReport) -> dict[str, Any]:
    return _rounded_values(asdict(report))


def _rounded_values(values: Mapping[str, Any]) -> dict[str, Any]:
    return {key: _rounded(value) if isinstance(value, float) else value for key, value in values.items()}


def _rounded(value: float) -> float:
    return round(float(value), DECIMALS) + 0.0
