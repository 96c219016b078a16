"""What watches one drive for people: scanners with their fields, vest cameras, and the truth beside them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.driving.drive_tracking import PERIOD, TrackingController, tangents
from pickcli.driving.driving_area import DrivingArea
from pickcli.geometry import Array
from pickcli.seeds import derived_rng
from pickcli.watching.brake_guards import Motion, ScannerGuard, VestGuard
from pickcli.watching.flash_pictures import FlashRenderer
from pickcli.watching.vest_detection import find_vests
from pickcli.watching.vest_tracking import VestTracker
from pickcli.watching.watch_file import Watch
from pickcli.watching.watch_truth import WatchTruth
from pickcli.watching.watched_drive import RequestReport
from pickcli.watching.watched_scene import WatchedScene

PROGRESS = 0.2  # m of travel from which on a truck that is braked again and again gets on
JUDGED_EVERY = 4  # sets of pictures between those of which it is told who was in view


@dataclass(frozen=True)
class Guards:
    """Which guards watch.

    Attributes:
        scanner: Whether the laser scanner does.
        vests: Whether the vest cameras do.
    """

    scanner: bool = True
    vests: bool = True


class _Due:
    """Tells at which instants something that has a period is due."""

    def __init__(self, period: float) -> None:
        self.period, self.next = period, 0.0

    def is_due(self, time: float) -> bool:
        if time < self.next - 1e-9:
            return False
        self.next += self.period
        return True


class DriveWatch:
    """Oversees a drive: asked once a period, it looks, requests brakes, and keeps what was true.

    Args:
        scene: The people and all else that is to be seen, on the clock of the drive.
        area: What stands where as the truck knows it, with the truck.
        watch: The sensors, fields and brake.
        guards: Which guards watch.
        seed: Seed of all noise.
        most_wait: s without ``PROGRESS`` of travel after which it gives up; endless by default.

    Attributes:
        truth: What was true.
        is_braked: In each period.
        tracks: By number of a track its places, s, m, m.
        n_pictures: Number of picture sets.
        has_given_up: Whether the drive ends where the truck stands.
    """

    def __init__(
        self, scene: WatchedScene, area: DrivingArea, watch: Watch, guards: Guards, seed: int,
        most_wait: float = np.inf,
    ) -> None:  # fmt: skip
        self.area, self.watch, self.guards, self.most_wait = area, watch, guards, most_wait
        self.rng = derived_rng("watched drive", seed)
        self.scanner = ScannerGuard(area, watch.scanner, watch.fields)
        self.rear = None if watch.rear is None else ScannerGuard(area, watch.rear, watch.fields)
        self.vests = VestGuard(area, VestTracker(watch.pair), watch.fields)
        self.renderer = FlashRenderer(watch.pair, scene, seed)
        self.truth = WatchTruth(scene, watch)
        self.is_braked: list[bool] = []
        self.requests: list[tuple[str, float]] = []
        self.tracks: dict[int, list[tuple[float, float, float]]] = {}
        self.n_pictures = 0
        self.has_given_up = False
        self._speed_before, self._progressed = 0.0, (0.0, 0.0)  # m/s; s and m of travel, at last
        self._scan, self._pictures = _Due(watch.scanner.period), _Due(watch.pair.period)

    @property
    def time(self) -> float:
        """Time (s) since the drive began."""
        return len(self.is_braked) * PERIOD

    def brakes(self, true: Array, believed: Array, controller: TrackingController) -> bool:
        """Look for people, and tell whether the truck brakes.

        Args:
            true: (3,) m, m, rad: where the truck truly is.
            believed: (3,) m, m, rad: where it believes to be.
            controller: How it moves.

        Returns:
            Whether it brakes, and stands then.
        """
        time, is_forwards = self.time, bool(controller.signs[0] > 0)
        speed, steering = float(controller.speed[0]), float(controller.steering[0])
        motion = Motion(speed, (speed - self._speed_before) / PERIOD, steering, is_forwards)
        self._speed_before = speed
        guard = self.scanner if is_forwards else self.rear
        was_braked = bool(self.is_braked and self.is_braked[-1])
        protective = None if guard is None else guard.field_for(motion, was_braked)
        scanner = self.watch.scanner if guard is None else guard.scanner
        ranges = self.truth.note(time, true, motion, protective, scanner)
        if self._scan.is_due(time) and guard is not None and protective is not None and self.guards.scanner:
            guard.take(time, scanner.measured(ranges, self.rng), believed, protective)
        if self.guards.vests:
            self._look(time, motion, was_braked, true, believed)
        self._note_requests(time)
        is_braked = any(each.request.is_braking(time) for each in self._guards)
        self.is_braked.append(is_braked)
        self._note_progress(time, float(controller.travel[0]), is_braked)
        return is_braked

    def _note_progress(self, time: float, travel: float, is_braked: bool) -> None:
        """Give up if the truck is braked, and did not get on for too long."""
        since, before = self._progressed
        if abs(travel - before) >= PROGRESS:
            self._progressed = time, travel
        self.has_given_up = is_braked and time - since >= self.most_wait

    @property
    def _guards(self) -> tuple[ScannerGuard | VestGuard, ...]:
        return tuple(each for each in (self.scanner, self.rear, self.vests) if each is not None)

    def _look(self, time: float, motion: Motion, was_braked: bool, true: Array, believed: Array) -> None:
        """Take pictures where they are due, and use the answers that have come."""
        if self._pictures.is_due(time):
            tangent = tangents(true[2:], np.array([motion.steering]))[0][0]
            tangent[2] /= self.area.truck.wheel_base

            def pose_at(at: float) -> Array:
                return np.asarray(true + (at - time) * motion.signed_speed * tangent)

            found = find_vests(self.watch.pair, self.renderer.pictures(time, pose_at, self.rng))
            if self.n_pictures % JUDGED_EVERY == 0:
                self.truth.note_pictures(time, self.renderer, found)
            self.n_pictures += 1
            self.vests.take(time, believed, found)
        seen_ahead = motion if motion.is_forwards else Motion(0.0, 0.0, 0.0)
        if self.vests.update(time, believed, seen_ahead, was_braked):
            self.truth.note_tracks(time, self.vests.tracker)
            for track in self.vests.tracker.tracks:
                if track.is_confirmed:
                    x, y = track.mean[:2].tolist()
                    self.tracks.setdefault(track.number, []).append((track.time, x, y))

    def _note_requests(self, time: float) -> None:
        """Keep requests that are new."""
        named = (("scanner", self.scanner), ("scanner", self.rear), ("vests", self.vests))
        for by, guard in named:
            since = -np.inf if guard is None else guard.request.since
            if np.isfinite(since) and (by, since) not in self.requests:
                self.requests.append((by, since))

    def reports(self) -> tuple[RequestReport, ...]:
        """Return what was true at each request.

        Returns:
            The reports, in the order of time.
        """
        found = [self.truth.request(by, since) for by, since in self.requests]
        return tuple(sorted(found, key=lambda each: each.time))
