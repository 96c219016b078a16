"""What is true while a drive is watched, and the reports that follow from it: no guard knows any of this."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pickcli.driving.drive_tracking import PERIOD
from pickcli.driving.steering_path import SteeringPath, posed, seen_from
from pickcli.geometry import Array
from pickcli.watching.brake_guards import Motion
from pickcli.watching.flash_pictures import FlashRenderer
from pickcli.watching.foreseen_contact import nearest_while_stopping, outline_distance, stopping_poses
from pickcli.watching.laser_scanner import LaserScanner
from pickcli.watching.protective_field import ProtectiveField
from pickcli.watching.stopping_distance import stopping_distance
from pickcli.watching.vest_detection import Vest
from pickcli.watching.vest_tracking import VestTrack, VestTracker
from pickcli.watching.watch_file import Watch
from pickcli.watching.watched_drive import PersonReport, RequestReport, TouchReport
from pickcli.watching.watched_scene import WatchedScene

IN_VIEW = 0.75  # share of a vest's body that both cameras see, from which it counts as in view
NEAR = (
    0.6  # m, and three standard deviations, from a person within which a detection or track is the person's
)
TOWARDS = 0.05  # m/s of the truck's side towards a person from which it is the truck that touches
LONGEST_FREE = 8.0  # whole m of travel that free distances are looked for in
BEFORE = 1.0  # s before a request in which its reason may have begun


@dataclass(eq=False)
class _Errors:
    """Sums over instants at which a track of a person was confirmed."""

    seen_time: float | None = None
    seen_distance: float | None = None
    probability: float | None = None
    position: list[float] = field(default_factory=list)
    velocity: list[float] = field(default_factory=list)


@dataclass(eq=False)
class WatchTruth:
    """Keeps the truth of a drive.

    Attributes:
        scene: The scene.
        watch: The sensors.
        poses: Of the truck, (3,) m, m, rad, each ``PERIOD``.
        motions: Of the truck, likewise.
        times: s.
    """

    scene: WatchedScene
    watch: Watch
    poses: list[Array] = field(default_factory=list)
    motions: list[Motion] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    _seen: list[NDArray[np.bool_]] = field(default_factory=list)
    _watched: list[ProtectiveField | None] = field(default_factory=list)
    _in_field: list[NDArray[np.bool_]] = field(default_factory=list)
    _needs_stop: list[NDArray[np.bool_]] = field(default_factory=list)
    _in_view: list[tuple[float, NDArray[np.bool_], NDArray[np.bool_]]] = field(default_factory=list)
    _errors: dict[int, _Errors] = field(default_factory=dict)
    _somebody: set[int] = field(default_factory=set)
    _nobody: set[int] = field(default_factory=set)

    @property
    def delay(self) -> float:
        """Time (s) until the truck brakes for what the vest guard knows."""
        return self.watch.fields.reaction + PERIOD

    def note(
        self, time: float, pose: Array, motion: Motion, protective: ProtectiveField | None,
        scanner: LaserScanner,
    ) -> Array:  # fmt: skip
        """Keep one instant, and cast the scanner's beams.

        Args:
            time: s.
            pose: (3,) m, m, rad: true pose of the truck.
            motion: How it moves.
            protective: The field that is watched; None while no sensor looks where it drives.
            scanner: The scanner that looks.

        Returns:
            (B,) m: ranges without noise.
        """
        walkers = self.scene.walkers
        posts = self.scene.discs(time)[: -2 * len(walkers) or None]
        ranges = scanner.ranges(pose, self.scene.segments(scanner.above), posts)
        none = np.zeros((0, 2, 2))
        of_walkers = [scanner.ranges(pose, none, walker.legs(time)) for walker in walkers]
        nearest = np.minimum.reduce([ranges, *of_walkers])
        hit = [(own <= nearest) & (own < scanner.farthest) for own in of_walkers]
        reach = np.zeros(len(nearest)) if protective is None else protective.reach
        self.poses.append(pose)
        self.motions.append(motion)
        self.times.append(time)
        self._watched.append(protective)
        self._seen.append(np.array([each.any() for each in hit], dtype=bool))
        self._in_field.append(np.array([(each & (nearest < reach)).any() for each in hit], dtype=bool))
        self._needs_stop.append(self._who_needs_a_stop(time, pose, motion))
        return np.asarray(nearest)

    def _who_needs_a_stop(self, time: float, pose: Array, motion: Motion) -> NDArray[np.bool_]:
        """(P,) for whom the vest cameras have to brake the truck, which look forwards."""
        walkers, figures = self.scene.walkers, self.watch.fields
        if not motion.is_forwards or motion.speed <= 0:
            return np.zeros(len(walkers), dtype=bool)
        stopping = stopping_poses(self.scene.area.truck, pose, (motion.speed, motion.steering), self.delay)
        keep = figures.body + figures.clearance
        return np.array([
            walker.has_vest and nearest_while_stopping(
                self.scene.area.truck, stopping, walker.place(time), walker.velocity(time)
            ) < keep
            for walker in walkers
        ], dtype=bool)  # fmt: skip

    def note_pictures(self, time: float, renderer: FlashRenderer, vests: list[Vest]) -> None:
        """Keep who was in view of one set of pictures, and who was found.

        Args:
            time: s of the exposure, the latest instant.
            renderer: What pictures are rendered by.
            vests: What was found.
        """
        pose = self.poses[-1]
        is_in_view = renderer.visible_shares(time, pose) >= IN_VIEW
        places = [seen_from(pose, np.array([*w.place(time), 0.0]))[:2] for w in self.scene.walkers]
        is_found = [any(_is_near(v.place[:2] - at, v.covariance) for v in vests) for at in places]
        self._in_view.append((time, is_in_view, np.array(is_found, dtype=bool)))

    def note_tracks(self, time: float, tracker: VestTracker) -> None:
        """Keep how far confirmed tracks are off, after answers came.

        Args:
            time: s at which they came.
            tracker: The tracker.
        """
        for track in tracker.tracks:
            if not track.is_confirmed:
                continue
            off = [track.mean[:2] - walker.place(track.time) for walker in self.scene.walkers]
            near = [k for k, each in enumerate(off) if _is_near(each, track.covariance[:2, :2])]
            if not near:
                self._nobody.add(track.number)
                continue
            self._somebody.add(track.number)
            k = min(near, key=lambda each: float(np.hypot(*off[each])))
            self._note_person(k, time, track, float(np.hypot(*off[k])))

    def _note_person(self, k: int, time: float, track: VestTrack, off: float) -> None:
        errors, walker = self._errors.setdefault(k, _Errors()), self.scene.walkers[k]
        if errors.seen_time is None:
            pair = self.watch.pair
            cameras = posed(self.poses[-1], np.array([pair.forward, 0.0, 0.0]))[:2]
            errors.seen_time = time
            errors.seen_distance = float(np.hypot(*(walker.place(track.time) - cameras)))
        errors.probability = track.probability
        errors.position.append(off)
        errors.velocity.append(float(np.hypot(*(track.mean[2:] - walker.velocity(track.time)))))

    @property
    def n_false(self) -> int:
        """Number of confirmed tracks that were nobody at any time."""
        return len(self._nobody - self._somebody)

    def people(self) -> tuple[PersonReport, ...]:
        """Return what the cameras saw of each person in a vest.

        Returns:
            The reports, in the order of the scene.
        """
        return tuple(self._person(k) for k, walker in enumerate(self.scene.walkers) if walker.has_vest)

    def _person(self, k: int) -> PersonReport:
        errors = self._errors.get(k, _Errors())
        times = [time for time, is_in_view, _ in self._in_view if is_in_view[k]]
        found = [is_found[k] for _, is_in_view, is_found in self._in_view if is_in_view[k]]
        return PersonReport(
            self.scene.walkers[k].name, times[0] if times else None, errors.seen_time, errors.seen_distance,
            errors.probability, len(times), int(sum(found)),
            _root_mean_square(errors.position), _root_mean_square(errors.velocity),
        )  # fmt: skip

    def request(self, by: str, time: float) -> RequestReport:
        """Return what was true when a brake was requested.

        Args:
            by: ``scanner`` or ``vests``.
            time: s of the request.

        Returns:
            The report.
        """
        truck, figures = self.scene.area.truck, self.watch.fields
        k = self._index(time)
        reasons = np.array((self._in_field if by == "scanner" else self._needs_stop)[: k + 1])
        since = [self._since(reasons[:, j], k) for j in range(reasons.shape[1])]
        known = [(begun, j) for j, begun in enumerate(since) if begun is not None]
        begun, who = min(known) if known else (None, None)
        speed = self.motions[k].speed
        # The reason began after the instant before the first one that shows it.
        delay = None if begun is None else time - self.times[max(begun - 1, 0)]
        return RequestReport(
            time, by, None if who is None else self.scene.walkers[who].name, speed, self.motions[k].steering,
            stopping_distance(speed, figures.reaction, truck.acceleration),
            self._free_travel(k), None if delay is None else max(delay, 0.0),
            self._watched[self._index(time - self.watch.scanner.delay if by == "scanner" else time)],
        )  # fmt: skip

    def _index(self, time: float) -> int:
        """Index of the instant nearest to a time."""
        return min(max(round(time / PERIOD), 0), len(self.times) - 1)

    def _since(self, reason: NDArray[np.bool_], k: int) -> int | None:
        """Index of the instant at which the latest reason began, if it was there lately."""
        lately = np.flatnonzero(reason[max(0, k - int(BEFORE / PERIOD)) : k + 1])
        if not len(lately):
            return None
        last = int(lately[-1]) + max(0, k - int(BEFORE / PERIOD))
        absent = np.flatnonzero(~reason[: last + 1])
        return int(absent[-1]) + 1 if len(absent) else 0

    def _free_travel(self, k: int) -> float | None:
        """Travel (m), with this steering angle, until the truck touches someone who stands still."""
        if not self.scene.walkers:
            return None
        truck, pose = self.scene.area.truck, self.poses[k]
        n = int(LONGEST_FREE)  # steps of a metre, in which the truck turns by less than a radian
        ahead = 1.0 if self.motions[k].is_forwards else -1.0
        path = SteeringPath(truck, pose, np.full(n, ahead), np.full(n + 1, self.motions[k].steering))
        travel = np.arange(0.0, LONGEST_FREE, 0.05)
        poses = path.poses_at(travel)
        places = [walker.place(self.times[k]) for walker in self.scene.walkers]
        met = np.minimum.reduce([outline_distance(truck, poses, np.tile(p, (len(poses), 1))) for p in places])
        touched = np.flatnonzero(met < self.watch.fields.body)
        return float(travel[touched[0]]) if len(touched) else None

    def touches(self) -> tuple[TouchReport, ...]:
        """Return whom the moving truck touched, each contact once.

        Returns:
            The reports, in the order of time.
        """
        found: list[TouchReport] = []
        truck, poses, times = self.scene.area.truck, np.array(self.poses), self.times
        for j, walker in enumerate(self.scene.walkers):
            places = np.array([walker.place(time) for time in times])
            is_near = outline_distance(truck, poses, places) < self.watch.fields.body
            touches = is_near & np.array([motion.speed > 0 for motion in self.motions])
            begins = np.flatnonzero(touches[1:] & ~touches[:-1]) + 1
            for k in begins.tolist():
                by_truck = self._speed_towards(k, places[k]) > TOWARDS
                avoidable = by_truck and self._is_avoidable(j, k)
                found.append(TouchReport(times[k], walker.name, self.motions[k].speed, by_truck, avoidable))
        return tuple(sorted(found, key=lambda each: each.time))

    def _speed_towards(self, k: int, place: Array) -> float:
        """Speed (m/s) of the truck's nearest point towards a place."""
        truck = self.scene.area.truck
        local = seen_from(self.poses[k], np.array([*place, 0.0]))[:2]
        half = truck.width / 2
        nearest = np.clip(local, [-truck.back, -half], [truck.front, half])
        before, now = (posed(self.poses[i], np.array([*nearest, 0.0]))[:2] for i in (k - 1, k))
        off = place - now
        return float((now - before) @ off / max(np.hypot(*off), 1e-9) / PERIOD)

    def _is_avoidable(self, j: int, k: int) -> bool:
        """Whether a stop that a sensor could have asked for at once would have left the person alone."""
        seen = np.array(self._seen)[: k + 1, j]
        hidden = np.flatnonzero(~seen)
        first = int(hidden[-1]) + 1 if len(hidden) else 0
        if first > k:
            return False
        watch, truck, walker = self.watch, self.scene.area.truck, self.scene.walkers[j]
        delay = watch.scanner.longest_response + watch.fields.reaction
        motion = self.motions[first]
        times, poses = stopping_poses(truck, self.poses[first], (motion.signed_speed, motion.steering), delay)
        fine = np.linspace(0.0, times[-1], 50)
        fine_poses = np.column_stack([np.interp(fine, times, poses[:, i]) for i in range(3)])
        places = np.array([walker.place(self.times[first] + t) for t in fine.tolist()])
        nearest = outline_distance(truck, fine_poses, places)
        return bool(nearest[fine < times[-1]].min() > watch.fields.body)


def _is_near(off: Array, covariance: Array) -> bool:
    return bool(np.hypot(*off) < NEAR + 3 * np.sqrt(covariance.trace() / 2))


def _root_mean_square(values: list[float]) -> float | None:
    return float(np.sqrt(np.mean(np.square(values)))) if values else None
