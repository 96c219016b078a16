"""Two guards that request a brake: the scanner with its protective field, and the tracks of people in vests.

The scanner needs nobody's vest and no tracks: a return inside the field in some scans in a row is a request.
The vests are seen farther off and with their velocity: a request is made when a stop that began now would
still come too near, whether the person walks on or stops.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.driving.drive_tracking import PERIOD
from pickcli.driving.driving_area import DrivingArea
from pickcli.driving.steering_path import posed
from pickcli.geometry import Array
from pickcli.watching.foreseen_contact import nearest_while_stopping, stopping_poses
from pickcli.watching.laser_scanner import LaserScanner
from pickcli.watching.protective_field import FieldFigures, FieldSet, ProtectiveField
from pickcli.watching.vest_detection import Vest
from pickcli.watching.vest_tracking import VestTracker

MOST_DOUBT = 0.3  # m of a track's error that is kept clear of, at most


@dataclass(frozen=True)
class Motion:
    """How a truck moves.

    Attributes:
        speed: m/s of the steered wheel.
        gain: m/s^2 by which it gets faster.
        steering: rad.
        is_forwards: Whether it drives to where its steered wheel is.
    """

    speed: float
    gain: float
    steering: float
    is_forwards: bool = True

    @property
    def signed_speed(self) -> float:
        """M/s, negative backwards."""
        return self.speed if self.is_forwards else -self.speed


@dataclass
class BrakeRequest:
    """The request of one guard.

    Attributes:
        figures: Reaction of the brake, and how long all is to be clear.
        since: s of the request, while there is one.
        latest: s at which there was last a reason for it.
    """

    figures: FieldFigures
    since: float = -np.inf
    latest: float = -np.inf

    def make(self, time: float) -> None:
        """State that there is a reason to brake.

        Args:
            time: s.
        """
        if not self.is_made(time):
            self.since = time
        self.latest = max(self.latest, time)

    def is_made(self, time: float) -> bool:
        """Return whether there is a request.

        Args:
            time: s.

        Returns:
            Whether there is one, since a reason or because it was not clear for long enough.
        """
        return self.since <= time < self.latest + self.figures.hold

    def is_braking(self, time: float) -> bool:
        """Return whether the truck brakes for it.

        Args:
            time: s.

        Returns:
            Whether the request was made so long ago that the brake acts.
        """
        return self.is_made(time) and time >= self.since + self.figures.reaction


class ScannerGuard:
    """The scanner and its fields.

    Args:
        area: What stands where; what is as near to it as the figures say does not brake the truck.
        scanner: The scanner.
        figures: Figures of the fields.
    """

    def __init__(self, area: DrivingArea, scanner: LaserScanner, figures: FieldFigures) -> None:
        self.area, self.scanner, self.figures = area, scanner, figures
        self.fields = FieldSet(area.truck, scanner, figures)
        self.request = BrakeRequest(figures)
        self.n_in_field = 0  # scans in a row

    def field_for(self, motion: Motion, is_braked: bool) -> ProtectiveField:
        """Return the field that is watched.

        Args:
            motion: How the truck moves.
            is_braked: Whether it brakes or was braked; then the field of the start must be clear, too.

        Returns:
            The field, for the speed that the truck gets to until it would brake.
        """
        speed = motion.speed + max(motion.gain, 0.0) * self.fields.delay
        if is_braked:
            speed = max(speed, self.figures.start_speed)
        return self.fields.field_for(min(speed, self.area.truck.speed), motion.steering)

    def take(self, time: float, ranges: Array, pose: Array, field: ProtectiveField) -> None:
        """Take in one scan.

        Args:
            time: s of the scan.
            ranges: (B,) m, measured.
            pose: (3,) m, m, rad: of the truck, as far as is known.
            field: The field.
        """
        inside = np.flatnonzero(ranges < field.reach)
        if len(inside):
            points = self.scanner.points(ranges)[inside]
            places = posed(pose, np.column_stack([points, np.zeros(len(points))]))[:, :2]
            inside = inside[~self._is_known(places)]
        self.n_in_field = self.n_in_field + 1 if len(inside) else 0
        if self.n_in_field >= self.scanner.scans:
            self.request.make(time + self.scanner.delay)

    def _is_known(self, places: Array) -> NDArray[np.bool_]:
        """(N,) whether walls or boxes that the area lists are near."""
        near = self.area.wall_distance(places) < self.figures.known
        for box in self.area.boxes:
            near = near | (box.distance(places) < self.figures.known)
        return np.asarray(near)


class VestGuard:
    """The tracks of people in vests.

    Args:
        area: The area with its truck.
        tracker: Follows the vests.
        figures: Figures of body, clearance and brake.
    """

    def __init__(self, area: DrivingArea, tracker: VestTracker, figures: FieldFigures) -> None:
        self.area, self.tracker, self.figures = area, tracker, figures
        self.request = BrakeRequest(figures)
        self.cause: int | None = None  # number of the track of the latest request
        self._answers: deque[tuple[float, Array, list[Vest]]] = deque()

    def take(self, time: float, pose: Array, vests: list[Vest]) -> None:
        """Take in what was found in pictures; it is used when the delay of the pair is over.

        Args:
            time: s of the exposure.
            pose: (3,) m, m, rad: of the truck then, as far as is known.
            vests: What was found.
        """
        self._answers.append((time, pose, vests))

    def update(self, time: float, pose: Array, motion: Motion, is_braked: bool) -> bool:
        """Follow the answers that have come, and request a brake if there is a reason.

        Args:
            time: s.
            pose: (3,) m, m, rad: of the truck now, as far as is known.
            motion: How it moves.
            is_braked: Whether it brakes or was braked; then the start must be clear, too.

        Returns:
            Whether answers came.
        """
        has_news = False
        while self._answers and self._answers[0][0] + self.tracker.pair.delay <= time + 1e-9:
            self.tracker.take(*self._answers.popleft())
            has_news = True
        speed = max(motion.speed, self.figures.start_speed) if is_braked else motion.speed
        delay = self.figures.reaction + PERIOD
        stopping = stopping_poses(self.area.truck, pose, (speed, motion.steering), delay)
        for track in (each for each in self.tracker.tracks if each.is_confirmed):
            mean, covariance = track.predicted(time)
            doubt = min(float(np.sqrt(covariance[:2, :2].trace() / 2)), MOST_DOUBT)
            keep = self.figures.body + self.figures.clearance + doubt
            nearest = min(
                nearest_while_stopping(self.area.truck, stopping, mean[:2], velocity)
                for velocity in (mean[2:], np.zeros(2))
            )
            if nearest < keep:
                self.request.make(time)
                self.cause = track.number
        return has_news
