"""Follows vests over pictures: where people are, how fast they walk, how probable it is that they are people.

Each track is a Kalman filter of place and velocity on the floor, with random accelerations. Detections go to
tracks by the assignment of least statistical distance in all. The probability is kept as log odds, as Sittler
(1964) scores tracks: a detection in its gate raises them by no more than a bound, because clutter that stands
still is found again and again; a miss where the vest should be in sight lowers them.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import linear_sum_assignment

from pickcli.driving.steering_path import posed, seen_from
from pickcli.geometry import Array
from pickcli.watching.nir_pair import NirPair
from pickcli.watching.vest_detection import Vest

ACCELERATION = 1.5  # m/s^2, standard deviation of a walk's
FIRST_SPEED = 1.2  # m/s, standard deviation of the velocity of a new track
GATE = 13.8  # squared statistical distance: 99.9 % of right ones in two dimensions
FIRST_ODDS = 0.8  # log odds of one detection alone
GAIN = 2.0  # log odds that a detection adds
LOSS = 1.2  # that a miss in sight takes
OUT_OF_SIGHT = 0.25  # that a picture takes in which the place is not in sight
MOST_ODDS = 6.0
CONFIRMED = 0.9  # probability from which a track counts
LOST = 0.05  # probability below which it is dropped
SCATTER = 1.5  # m, deviation of a place at which it is dropped
SIGHT = 0.95  # of the half field of view, within which a vest should be found


@dataclass(eq=False)
class VestTrack:
    """One followed vest.

    Attributes:
        number: From 1, in the order of their first detections.
        time: s of the estimate.
        mean: (4,) x, y in m and velocities in m/s, on the floor.
        covariance: (4, 4).
        log_odds: Of being a person.
        confirmed_time: s of the picture by which the track was confirmed first; None before.
        n_found: Number of detections.
    """

    number: int
    time: float
    mean: Array
    covariance: Array
    log_odds: float = FIRST_ODDS
    confirmed_time: float | None = None
    n_found: int = 1

    @property
    def probability(self) -> float:
        """That this is a person in a vest."""
        return float(1 / (1 + np.exp(-self.log_odds)))

    @property
    def is_confirmed(self) -> bool:
        """Whether the track counts now."""
        return self.probability >= CONFIRMED

    def predicted(self, time: float) -> tuple[Array, Array]:
        """Return the estimate for another time.

        Args:
            time: s.

        Returns:
            (4,) mean, (4, 4) covariance.
        """
        dt = time - self.time
        F = np.eye(4)
        F[:2, 2:] = dt * np.eye(2)
        push = np.vstack([dt**2 / 2 * np.eye(2), dt * np.eye(2)]) * ACCELERATION
        return F @ self.mean, np.asarray(F @ self.covariance @ F.T + push @ push.T)

    def correct(self, place: Array, covariance: Array) -> None:
        """Take a detection in, at the time that the track is predicted to.

        Args:
            place: (2,) m on the floor.
            covariance: (2, 2) m^2.
        """
        gain = self.covariance[:, :2] @ np.linalg.inv(self.covariance[:2, :2] + covariance)
        self.mean = self.mean + gain @ (place - self.mean[:2])
        kept = np.eye(4)
        kept[:, :2] -= gain
        self.covariance = kept @ self.covariance @ kept.T + gain @ covariance @ gain.T
        self.n_found += 1


@dataclass(eq=False)
class VestTracker:
    """All tracks of one pair.

    Attributes:
        pair: The pair.
        tracks: Those that are followed now.
        n_tracks: Number of all tracks so far.
    """

    pair: NirPair
    tracks: list[VestTrack] = field(default_factory=list)
    n_tracks: int = 0

    def take(self, time: float, pose: Array, vests: list[Vest]) -> None:
        """Take in what was found in one set of pictures.

        Args:
            time: s of the exposure.
            pose: (3,) m, m, rad: of the truck then, as far as is known.
            vests: What was found.
        """
        c, s = np.cos(pose[2]), np.sin(pose[2])
        R = np.array([[c, -s], [s, c]])
        places = [posed(pose, np.array([*vest.place[:2], 0.0]))[:2] for vest in vests]
        spreads = [R @ vest.covariance @ R.T for vest in vests]
        for track in self.tracks:
            track.mean, track.covariance = track.predicted(time)
            track.time = time
        taken = self._assigned(places, spreads)
        for k, track in enumerate(self.tracks):
            if k in taken:
                track.correct(places[taken[k]], spreads[taken[k]])
                track.log_odds = min(track.log_odds + GAIN, MOST_ODDS)
            else:
                track.log_odds -= LOSS if self._is_in_sight(track, pose) else OUT_OF_SIGHT
        for j in sorted(set(range(len(vests))) - set(taken.values())):
            self._begin(time, places[j], spreads[j])
        for track in self.tracks:
            if track.is_confirmed and track.confirmed_time is None:
                track.confirmed_time = time
        self.tracks = [
            track for track in self.tracks
            if track.probability >= LOST and track.covariance[:2, :2].trace() < SCATTER**2
        ]  # fmt: skip

    def _assigned(self, places: list[Array], spreads: list[Array]) -> dict[int, int]:
        """Indices of detections by those of tracks."""
        if not self.tracks or not places:
            return {}
        costs = np.full((len(self.tracks), len(places)), 10 * GATE)
        for k, track in enumerate(self.tracks):
            for j, (place, spread) in enumerate(zip(places, spreads, strict=True)):
                off, S = place - track.mean[:2], track.covariance[:2, :2] + spread
                costs[k, j] = min(float(off @ np.linalg.solve(S, off)), 10 * GATE)
        rows, columns = linear_sum_assignment(costs)
        pairs = zip(rows.tolist(), columns.tolist(), strict=True)
        return {k: j for k, j in pairs if costs[k, j] < GATE}

    def _is_in_sight(self, track: VestTrack, pose: Array) -> bool:
        x, y, _ = seen_from(pose, np.array([*track.mean[:2], 0.0])).tolist()
        depth = x - self.pair.forward
        half = SIGHT * self.pair.field_of_view / 2
        return bool(self.pair.nearest < depth < self.pair.farthest and abs(np.arctan2(y, depth)) < half)

    def _begin(self, time: float, place: Array, spread: Array) -> None:
        covariance = np.zeros((4, 4))
        covariance[:2, :2] = spread
        covariance[2:, 2:] = FIRST_SPEED**2 * np.eye(2)
        self.n_tracks += 1
        mean = np.array([*place, 0.0, 0.0])
        self.tracks.append(VestTrack(self.n_tracks, time, mean, covariance))
