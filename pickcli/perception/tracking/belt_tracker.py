"""Tracks items on a conveyor: where each will be, and how well that is known (Cowley et al. 2013, III-E)."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from pickcli.cell.conveyor import Conveyor
from pickcli.cell.item import Item
from pickcli.errors import InputError
from pickcli.geometry import Array, rotation_axis_angle
from pickcli.perception.tracking.alignment import aligned
from pickcli.perception.tracking.belt_filter import BeltFilter
from pickcli.perception.tracking.mean_yaw import mean_yaw
from pickcli.perception.tracking.sighting import Detection, Sighting, SightingNoise
from pickcli.scene.scene import PoseNoise

LEAST_SIGHTINGS = 3  # until a track is reported (V-C)
GATE = 4.0  # standard deviations beyond which a detection is another item's
WITHIN = 4.0  # standard deviations within which the length of an error in three axes is: 99.9 %
LONGEST_UNSEEN = 0.5  # s after which what was seen less often than LEAST_SIGHTINGS was nothing
MOST_MISSED = 5  # pictures in a row that should show an item and do not, after which it is gone
YAWS = 20  # latest ones of an item that are averaged


@dataclass(frozen=True, eq=False)
class BeltTrack:
    """An item on the belt as it is known.

    Attributes:
        id: Its label, if any was seen; otherwise product and number.
        item: The product.
        n_sightings: Pictures in which it was seen.
        T_belt_item: (4, 4) pose in the frame of the conveyor, at the time that was asked for.
        noise: Bounds of the error of that pose.
    """

    id: str
    item: Item
    n_sightings: int
    T_belt_item: Array
    noise: PoseNoise


@dataclass(eq=False)
class _Tracked:
    """An item that was seen; its place along the belt is in the filter."""

    number: int
    item: Item
    R_belt_item: Array  # (3, 3) as it was first seen
    across: Array  # (2,) m, mean of y and z
    t_seen: float
    n: int = 1
    n_missed: int = 0  # pictures since then that should have shown it
    yaws: deque[float] = field(default_factory=lambda: deque([0.0], maxlen=YAWS))
    labels: Counter[str] = field(default_factory=Counter)

    @property
    def id(self) -> str:
        """The commonest label, or product and number."""
        return self.labels.most_common(1)[0][0] if self.labels else f"{self.item.name}#{self.number}"

    def see(self, detection: Detection, t: float) -> None:
        """Average what the filter does not: place across the belt, height and yaw."""
        T = detection.T_belt_item
        self.n, self.t_seen, self.n_missed = self.n + 1, t, 0
        self.across = self.across + (T[1:3, 3] - self.across) / self.n
        turn = T[:3, :3] @ self.R_belt_item.T
        self.yaws.append(float(np.arctan2(turn[1, 0] - turn[0, 1], turn[0, 0] + turn[1, 1])))
        self.labels.update([detection.label] if detection.label else [])


class BeltTracker:
    """Tracks what comes along a conveyor.

    Pictures are known later than the encoder: they are worked in at the times at which they were taken.

    Args:
        belt: Figures of the conveyor.
        noise: Errors of detections.
        t: s, time of the first reading of the encoder.
        travel: m, that reading.
    """

    def __init__(self, belt: Conveyor, noise: SightingNoise, t: float, travel: float) -> None:
        self._belt, self._noise, self._n_seen = belt, noise, 0
        self._filter = BeltFilter(t, travel, belt)
        self._readings: list[tuple[float, float]] = []  # later than the last picture
        self._tracked: list[_Tracked] = []  # in the order of the filter

    def read_encoder(self, t: float, travel: float) -> None:
        """Take note of a reading of the encoder.

        Args:
            t: s at which the belt had travelled so far.
            travel: m.

        Raises:
            InputError: It is older than the reading before.
        """
        last = self._readings[-1][0] if self._readings else self._filter.t
        if t < last:
            raise InputError(f"encoder: a reading of {t:.3f} s after one of {last:.3f} s; send them in order")
        self._readings.append((t, travel))

    def see(self, sighting: Sighting) -> None:
        """Work in what a picture shows.

        Args:
            sighting: The picture.

        Raises:
            InputError: It is older than the picture before, or newer than the encoder's last reading.
        """
        t, newest = sighting.stamp, self._readings[-1][0] if self._readings else self._filter.t
        if not self._filter.t <= t <= newest:
            known = f"known are {self._filter.t:.3f} to {newest:.3f} s"
            raise InputError(
                f"sighting: stamp {t:.3f} s is out of order ({known}); is its clock the encoder's?"
            )
        self._filter = self._at(t)
        self._readings = [reading for reading in self._readings if reading[0] > t]
        self._drop(t)
        self._match(sighting)

    def tracks(self, t: float) -> tuple[BeltTrack, ...]:
        """Return the items that were seen often enough, as they are at a time.

        Args:
            t: s, not before the last picture.

        Returns:
            The tracks, the one farthest along the belt first. Of two with one label only the one that was
            seen last: the item was moved.
        """
        now = self._at(t)
        found: dict[str, BeltTrack] = {}
        by_age = sorted(range(len(self._tracked)), key=lambda k: self._tracked[k].t_seen)
        for k in by_age:
            tracked, (place, deviation) = self._tracked[k], now.place(k)
            if tracked.n >= LEAST_SIGHTINGS and place <= self._belt.length:
                pose = self._pose(tracked, place, deviation)
                found[tracked.id] = BeltTrack(tracked.id, tracked.item, tracked.n, *pose)
        return tuple(sorted(found.values(), key=lambda track: -float(track.T_belt_item[0, 3])))

    def speed(self, t: float) -> tuple[float, float]:
        """Return the speed of the belt.

        Args:
            t: s, not before the last picture.

        Returns:
            m/s, and the standard deviation of the error.
        """
        return self._at(t).speed

    def forget(self, track_id: str) -> None:
        """Remove what was taken off the belt, or moved on it.

        Args:
            track_id: Id of a track; of one that is unknown nothing is removed.
        """
        self._remove([k for k, tracked in enumerate(self._tracked) if tracked.id == track_id])

    def _at(self, t: float) -> BeltFilter:
        """Return the filter at a time, by the readings until then."""
        later = self._filter.copy()
        for t_reading, travel in self._readings:
            if t_reading <= t:
                later.read_encoder(t_reading, travel)
        later.advance(t)
        return later

    def _drop(self, t: float) -> None:
        """Remove what has left the belt, or its place on it, and what was seen too rarely to be anything."""
        is_gone = (
            self._filter.place(k)[0] > self._belt.length
            or tracked.n_missed >= MOST_MISSED
            or (tracked.n < LEAST_SIGHTINGS and t - tracked.t_seen > LONGEST_UNSEEN)
            for k, tracked in enumerate(self._tracked)
        )
        self._remove([k for k, gone in enumerate(is_gone) if gone])

    def _remove(self, gone: Iterable[int]) -> None:
        for k in sorted(gone, reverse=True):
            self._filter.remove(k)
            del self._tracked[k]

    def _match(self, sighting: Sighting) -> None:
        """Give every detection to the track that it is of, or begin a new one."""
        order = sorted(range(len(self._tracked)), key=lambda k: self._filter.place(k)[0])
        seen = sorted(sighting.detections, key=lambda each: float(each.T_belt_item[0, 3]))
        gains = np.array([[self._gain(k, each) for each in seen] for k in order]).reshape(
            len(order), len(seen)
        )
        pairs = {j: order[i] for i, j in aligned(gains)}
        fits = np.any(gains > 0.0, axis=1)
        for i, k in enumerate(order):
            is_in_view = sighting.view[0] <= self._filter.place(k)[0] <= sighting.view[1]
            self._tracked[k].n_missed += is_in_view and not fits[i]
        for j, k in pairs.items():
            self._filter.see(k, float(seen[j].T_belt_item[0, 3]), self._noise.position)
            self._tracked[k].see(seen[j], sighting.stamp)
        for j, each in enumerate(seen):
            if j not in pairs and not self._is_double(each):
                self._begin(each, sighting.stamp)

    def _gain(self, k: int, detection: Detection) -> float:
        """Return how well a detection fits a track: from GATE^2 where it is exact, to 0 at the gate."""
        tracked, (place, deviation) = self._tracked[k], self._filter.place(k)
        if (detection.item.name, detection.item.year) != (tracked.item.name, tracked.item.year):
            return -np.inf
        if detection.label and tracked.labels and detection.label != tracked.id:
            return -np.inf
        sigma = self._noise.position
        along = (float(detection.T_belt_item[0, 3]) - place) / np.hypot(deviation, sigma)
        across = (float(detection.T_belt_item[1, 3]) - tracked.across[0]) / (
            sigma * np.sqrt(1 + 1 / tracked.n)
        )
        return float(GATE**2 - along**2 - across**2)

    def _is_double(self, detection: Detection) -> bool:
        """Whether something is tracked so near to a detection that there is no room for another solid."""
        own = _inscribed(detection.item)
        for k, tracked in enumerate(self._tracked):
            centre = np.array([self._filter.place(k)[0], *tracked.across])
            apart = float(np.linalg.norm(detection.T_belt_item[:3, 3] - centre))
            if apart < own + _inscribed(tracked.item):
                return True
        return False

    def _begin(self, detection: Detection, t: float) -> None:
        T = detection.T_belt_item
        self._n_seen += 1
        labels = Counter([detection.label] if detection.label else [])
        self._tracked.append(
            _Tracked(self._n_seen, detection.item, T[:3, :3], T[1:3, 3], t, labels=labels)
        )  # fmt: skip
        self._filter.add(float(T[0, 3]), self._noise.position)

    def _pose(self, tracked: _Tracked, place: float, deviation: float) -> tuple[Array, PoseNoise]:
        """Return the pose of a track whose place along the belt is known to a deviation, with its bounds."""
        yaw, n_yaws = mean_yaw(np.array(tracked.yaws), self._noise.angle)
        T = np.eye(4)
        T[:3, :3] = rotation_axis_angle((0.0, 0.0, 1.0), yaw) @ tracked.R_belt_item
        T[:3, 3] = place, *tracked.across
        sigma = max(deviation, self._noise.position / np.sqrt(tracked.n))
        angle = float(WITHIN * self._noise.angle / np.sqrt(n_yaws))
        return T, PoseNoise(float(WITHIN * sigma) + self._noise.mount, angle)


def _inscribed(item: Item) -> float:
    """Return the radius in m of a ball within an item."""
    return float(item.shape.extents.min()) / 2
