"""The quickest speeds along a path of the truck within its limits, everywhere and not only at samples.

The square of the speed is linear in the travel between two points, where the acceleration is constant. It is
at most the least limit of the whole part between them: steering angles are linear there, so that their sine
is largest at one end.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.driving.steering_path import SteeringPath
from pickcli.driving.tricycle import PLANNED_SHARE
from pickcli.geometry import Array

PROFILE_STEP = 0.02  # m of travel between two points, at most


@dataclass(frozen=True, eq=False)
class SpeedProfile:
    """Speeds at points of a path.

    Attributes:
        travel: (N,) m from the start of the path, increasing.
        speeds: (N,) m/s of the steered wheel, either way positive; 0 at both ends and at cusps.
        times: (N,) s.
    """

    travel: Array
    speeds: Array
    times: Array

    @property
    def duration(self) -> float:
        """Time (s) from start to end."""
        return float(self.times[-1])

    def travel_at(self, times: Array) -> Array:
        """Return the travel at times.

        Args:
            times: (M,) s.

        Returns:
            (M,) m.
        """
        k = np.clip(np.searchsorted(self.times, times, side="right") - 1, 0, len(self.times) - 2)
        since, whole = times - self.times[k], self.times[k + 1] - self.times[k]
        change = (self.speeds[k + 1] - self.speeds[k]) / whole
        return self.travel[k] + self.speeds[k] * since + change * since**2 / 2

    def times_at(self, travel: Array) -> Array:
        """Return when the truck is where: the inverse of ``travel_at``.

        Args:
            travel: (M,) m.

        Returns:
            (M,) s.
        """
        k = np.clip(np.searchsorted(self.travel, travel, side="right") - 1, 0, len(self.travel) - 2)
        since, squares = travel - self.travel[k], self.speeds**2
        square = squares[k] + (squares[k + 1] - squares[k]) * since / (self.travel[k + 1] - self.travel[k])
        speed = self.speeds[k] + np.sqrt(np.maximum(square, 0.0))
        part: Array = np.divide(since, speed, out=np.zeros_like(since), where=speed > 0.0)
        return self.times[k] + 2 * part


def speed_profile(path: SteeringPath) -> SpeedProfile:
    """Time a path by two passes over it (Bobrow et al., IJRR 4(3), 1985).

    Args:
        path: The path.

    Returns:
        The quickest profile within ``PLANNED_SHARE`` of the truck's limits that rests at both ends and at
        cusps.
    """
    truck = path.truck
    lengths = np.diff(path.knots)
    parts = [
        np.linspace(0.0, 1.0, max(2, int(np.ceil(length / PROFILE_STEP))), endpoint=False)
        for length in lengths.tolist()
    ]
    travel = np.concatenate(
        [at + length * part for at, length, part in zip(path.knots, lengths, parts, strict=False)]
        + [path.knots[-1:]]
    )
    steering = path.steering_at(travel)
    sine = np.abs(np.sin(steering))
    most = np.maximum(sine[:-1], sine[1:]) / truck.wheel_base
    slopes = np.repeat(np.abs(np.diff(path.steering)) / lengths, [len(part) for part in parts])
    tiny = 1e-12
    squares = np.minimum.reduce(
        [
            np.full(len(most), (PLANNED_SHARE * truck.speed) ** 2),
            PLANNED_SHARE * truck.centripetal / np.maximum(most, tiny),
            (PLANNED_SHARE * truck.steering_rate / np.maximum(slopes, tiny)) ** 2,
        ]
    )
    at_points = np.minimum(np.append(squares, np.inf), np.append(np.inf, squares))
    rests = np.concatenate([[0.0], path.knots[path.cusps], path.knots[-1:]])
    at_points[np.searchsorted(travel, rests)] = 0.0
    gains = 2 * PLANNED_SHARE * truck.acceleration * np.diff(travel)
    forth = _rising(at_points, gains)
    both = _rising(forth[::-1], gains[::-1])[::-1]
    speeds = np.sqrt(both)
    times = np.concatenate([[0.0], (2 * np.diff(travel) / (speeds[:-1] + speeds[1:])).cumsum()])
    return SpeedProfile(travel, speeds, times)


def _rising(limits: Array, gains: Array) -> Array:
    """Largest values within limits (N,) that rise from one to the next by at most gains (N - 1,)."""
    values = limits.tolist()
    for k, gain in enumerate(gains.tolist()):
        values[k + 1] = min(values[k + 1], values[k] + gain)
    return np.array(values)
