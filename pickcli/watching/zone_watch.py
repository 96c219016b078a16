"""Plays a drive through a watched scene: sensors, guards and brake, with the truth beside them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.driving.drive_plan import DrivePlan
from pickcli.driving.drive_tracking import PERIOD, TrackingController, tangents
from pickcli.driving.simulated_drives import DriveNoise, NoisyTruck
from pickcli.geometry import Array
from pickcli.progress import Progress, ProgressObserver, nobody
from pickcli.seeds import derived_rng
from pickcli.watching.brake_guards import Motion, ScannerGuard, VestGuard
from pickcli.watching.flash_pictures import FlashRenderer
from pickcli.watching.vest_detection import find_vests
from pickcli.watching.vest_tracking import VestTracker
from pickcli.watching.watch_file import Watch
from pickcli.watching.watch_truth import WatchTruth
from pickcli.watching.watched_drive import RequestReport, WatchedDrive
from pickcli.watching.watched_scene import WatchedScene

BELIEVED_EVERY = 0.1  # s between two localisations
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


class _Play:
    """One drive, instant by instant."""

    def __init__(self, plan: DrivePlan, scene: WatchedScene, watch: Watch, guards: Guards, seed: int) -> None:
        self.plan, self.scene, self.watch, self.guards = plan, scene, watch, guards
        self.rng = derived_rng("watched drive", seed)
        self.controller = TrackingController(plan, 1)
        rng, truck = derived_rng("drives", seed), plan.area.truck
        self.truck = NoisyTruck(truck, plan.area.start, DriveNoise(), 1, rng)
        self.scanner = ScannerGuard(plan.area, watch.scanner, watch.fields)
        self.vests = VestGuard(plan.area, VestTracker(watch.pair), watch.fields)
        self.renderer = FlashRenderer(watch.pair, scene, seed)
        self.truth = WatchTruth(scene, watch)
        self.is_braked: list[bool] = []
        self.requests: list[tuple[str, float]] = []
        self.tracks: dict[int, list[tuple[float, float, float]]] = {}
        self.unwatched, self._speed_before, self.n_pictures = 0.0, 0.0, 0
        self._fix, self._scan = _Due(BELIEVED_EVERY), _Due(watch.scanner.period)
        self._pictures = _Due(watch.pair.period)

    def step(self, time: float) -> bool:
        """Play one period; whether the truck is at its goal."""
        if self._fix.is_due(time):
            self.truck.localise()
        true, believed = self.truck.true[0], self.truck.believed[0]
        speed, steering = float(self.controller.speed[0]), float(self.controller.steering[0])
        motion = Motion(speed, (speed - self._speed_before) / PERIOD, steering)
        self._speed_before = speed
        is_watched = bool(self.controller.signs[0] > 0)
        was_braked = bool(self.is_braked and self.is_braked[-1])
        protective = self.scanner.field_for(motion, was_braked) if is_watched else None
        ranges = self.truth.note(time, true, motion, protective)
        if self._scan.is_due(time) and protective is not None and self.guards.scanner:
            self.scanner.take(time, self.watch.scanner.measured(ranges, self.rng), believed, protective)
        if self.guards.vests:
            self._look(time, motion, was_braked, is_watched)
        self._note_requests(time)
        is_braked = any(guard.request.is_braking(time) for guard in (self.scanner, self.vests))
        self.is_braked.append(is_braked)
        self.controller.control(self.truck.believed, np.array([is_braked]))
        step = self.controller.signs * self.controller.speed * PERIOD
        self.unwatched += float(np.maximum(-step, 0.0)[0])
        self.truck.move(self.controller.steering, step)
        self.controller.advance()
        return bool(self.controller.is_done[0])

    def _look(self, time: float, motion: Motion, was_braked: bool, is_watched: bool) -> None:
        """Take pictures where they are due, and use the answers that have come."""
        true, believed = self.truck.true[0], self.truck.believed[0]
        if self._pictures.is_due(time):
            signed = motion.speed * float(self.controller.signs[0])
            tangent = tangents(true[2:], np.array([motion.steering]))[0][0]
            tangent[2] /= self.plan.area.truck.wheel_base

            def pose_at(at: float) -> Array:
                return np.asarray(true + (at - time) * signed * tangent)

            found = find_vests(self.watch.pair, self.renderer.pictures(time, pose_at, self.rng))
            if self.n_pictures % JUDGED_EVERY == 0:
                self.truth.note_pictures(time, self.renderer, found)
            self.n_pictures += 1
            self.vests.take(time, believed, found)
        if self.vests.update(time, believed, motion if is_watched else Motion(0.0, 0.0, 0.0), was_braked):
            self.truth.note_tracks(time, self.vests.tracker)
            for track in self.vests.tracker.tracks:
                if track.is_confirmed:
                    x, y = track.mean[:2].tolist()
                    self.tracks.setdefault(track.number, []).append((track.time, x, y))

    def _note_requests(self, time: float) -> None:
        """Keep requests that are new."""
        for by, guard in (("scanner", self.scanner), ("vests", self.vests)):
            since = guard.request.since
            if np.isfinite(since) and (by, since) not in self.requests:
                self.requests.append((by, since))

    def reports(self) -> tuple[RequestReport, ...]:
        """What was true at each request."""
        found = [self.truth.request(by, since) for by, since in self.requests]
        return tuple(sorted(found, key=lambda each: each.time))


def watch_zone(
    plan: DrivePlan, scene: WatchedScene, watch: Watch, seed: int, guards: Guards | None = None,
    observe: ProgressObserver = nobody,
) -> WatchedDrive:  # fmt: skip
    """Play a drive through a watched scene.

    Args:
        plan: The drive.
        scene: The scene.
        watch: The sensors, fields and brake.
        seed: Seed of all noise.
        guards: Which guards watch; None for both.
        observe: Told of the progress.

    Returns:
        What came of it.
    """
    play = _Play(plan, scene, watch, guards or Guards(), seed)
    n, arrived = int(scene.duration / PERIOD), False
    for k in range(n):
        arrived = play.step(k * PERIOD)
        if arrived:
            break
        if k % 50 == 0:
            observe(Progress(k, n))
    truth = play.truth
    return WatchedDrive(
        scene, np.array(truth.poses), np.array([motion.speed for motion in truth.motions]),
        np.array(play.is_braked), arrived, play.unwatched, truth.people(), play.reports(), truth.touches(),
        truth.n_false, play.n_pictures, {number: np.array(rows) for number, rows in play.tracks.items()},
    )  # fmt: skip
