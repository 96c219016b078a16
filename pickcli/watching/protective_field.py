"""Protective fields: what the truck sweeps until it rests, with supplements, as ranges of beams.

As with real scanners, a field is one range for each beam: whatever is nearer along the beam is in it. It
holds all that the truck's outline sweeps until it rests, at the steering angle that it has and at some more
and less, as far as beams get there. The outline is widened by supplements, and by the way of somebody who
walks up to the truck until it gets there: K T of ISO 13855, with the time T to each place of the truck.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np

from pickcli.driving.tricycle import Tricycle
from pickcli.geometry import Array
from pickcli.watching.foreseen_contact import stopping_poses
from pickcli.watching.laser_scanner import LaserScanner
from pickcli.watching.stopping_distance import stopping_distance

INSTANTS = 61  # of the time to rest, whose outlines make a field
SPEED_STEP = 0.1  # m/s between two fields
STEERING_STEP = 0.1  # rad between two fields; each is for as much more and less, too


@dataclass(frozen=True)
class FieldFigures:
    """How fields are cut, and how the truck brakes.

    Attributes:
        reaction: s from a request until the truck brakes.
        hold: s that everything is clear before it goes on.
        start_speed: m/s, for which the field is to be clear before it goes on.
        ahead: m in front of the stopping distance, for errors of the scanner.
        side: m beside the truck, likewise.
        approach: m/s at which people may walk up to the truck.
        known: m around walls and boxes that the area lists, in which nothing brakes the truck.
        body: m, radius of a person seen from above.
        clearance: m that the truck is to keep from people in vests, beside the error of where they are.
    """

    reaction: float
    hold: float
    start_speed: float
    ahead: float
    side: float
    approach: float
    known: float
    body: float
    clearance: float


@dataclass(frozen=True, eq=False)
class ProtectiveField:
    """One field.

    Attributes:
        speed: m/s of the steered wheel, for which it is.
        steering: rad, for which it is.
        stopping: m of travel of the steered wheel to the rest.
        angles: (B,) rad of the beams to the truck's x.
        reach: (B,) m along each beam.
        forward: m of the scanner before the axle.
    """

    speed: float
    steering: float
    stopping: float
    angles: Array
    reach: Array
    forward: float

    @property
    def outline(self) -> Array:
        """(B + 1, 2) m: its corners in the frame of the truck, the scanner the last."""
        ends = np.column_stack([np.cos(self.angles), np.sin(self.angles)]) * self.reach[:, None]
        corners: Array = np.vstack([ends, np.zeros(2)]) + np.array([self.forward, 0.0])
        return corners


class FieldSet:
    """Fields for all speeds and steering angles of a truck, made when they are first needed.

    Args:
        truck: The truck.
        scanner: The scanner.
        figures: Supplements and brake.
    """

    def __init__(self, truck: Tricycle, scanner: LaserScanner, figures: FieldFigures) -> None:
        self.truck, self.scanner, self.figures = truck, scanner, figures
        self.delay = scanner.longest_response + figures.reaction
        self._made: dict[tuple[int, int], ProtectiveField] = {}

    def field_for(self, speed: float, steering: float) -> ProtectiveField:
        """Return the field for a speed and a steering angle.

        Args:
            speed: m/s of the steered wheel, to where the scanner looks.
            steering: rad.

        Returns:
            That of the next higher speed and the nearest steering angle that there is a field for.
        """
        key = ceil(speed / SPEED_STEP - 1e-9), round(steering / STEERING_STEP)
        if key not in self._made:
            self._made[key] = self._cut(key[0] * SPEED_STEP, key[1] * STEERING_STEP)
        return self._made[key]

    def _cut(self, speed: float, steering: float) -> ProtectiveField:
        stopping = stopping_distance(speed, self.delay, self.truck.acceleration)
        most = self.truck.steering
        reach = np.zeros(len(self.scanner.angles))
        for angle in (steering - STEERING_STEP, steering, steering + STEERING_STEP):
            swept = self._swept(speed, float(np.clip(angle, -most, most)))
            np.maximum(reach, swept, out=reach)
        reach = np.minimum(reach, self.scanner.farthest)
        return ProtectiveField(speed, steering, stopping, self.scanner.angles, reach, self.scanner.forward)

    def _swept(self, speed: float, steering: float) -> Array:
        """(B,) m along beams to the last point that the widened outline sweeps."""
        signed = -speed if self.scanner.looks_back else speed
        times, poses = stopping_poses(self.truck, np.zeros(3), (signed, steering), self.delay, INSTANTS)
        wider = np.array([self.figures.ahead, self.figures.side]) + self.figures.approach * times[:, None]
        return _last_inside(self.scanner, poses, self.truck, wider)


def _last_inside(scanner: LaserScanner, poses: Array, truck: Tricycle, wider: Array) -> Array:
    """(B,) m along beams to the end of outlines at (K, 3) poses, (K, 2) m longer and wider, by slabs."""
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    R = np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)  # of the poses to the frame of the truck
    origin = np.einsum("kji,kj->ki", R, [scanner.forward, 0.0] - poses[:, :2])
    beams = np.einsum("kji,bj->kbi", R, scanner.directions)
    half = truck.width / 2
    low, high = np.array([-truck.back, -half]) - wider, np.array([truck.front, half]) + wider
    with np.errstate(divide="ignore", invalid="ignore"):
        a = (low - origin)[:, None] / beams
        b = (high - origin)[:, None] / beams
    near = np.nan_to_num(np.minimum(a, b), nan=-np.inf).max(axis=-1)
    far = np.nan_to_num(np.maximum(a, b), nan=np.inf, posinf=np.inf).min(axis=-1)
    last: Array = np.where(far >= np.maximum(near, 0.0), far, 0.0).max(axis=0)
    return last
