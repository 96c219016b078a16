"""Parabolic segments: every joint ramps to a speed of its own, keeps it, and ramps to its final speed.

All joints start and end together and are otherwise independent, so only the slowest one needs its limits; the
others have time to spare (Hauser and Ng-Thow-Hing 2010, with the speeds of all joints free at both ends).
Ramps begin and end on ticks, so a filtered motion never switches between two ticks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.geometry import Array

TICK = 0.001  # s

_NOTHING = 1e-12  # m or rad: what counts as no way at all


@dataclass(frozen=True, eq=False)
class JointState:
    """Positions and velocities of all joints at one time.

    Attributes:
        q: (n,) rad or m.
        v: (n,) rad/s or m/s.
    """

    q: Array
    v: Array

    @classmethod
    def at_rest(cls, q: Array) -> JointState:
        """The state at rest in a configuration.

        Args:
            q: (n,) rad or m.

        Returns:
            The state with zero velocities.
        """
        return cls(q, np.zeros(len(q)))


@dataclass(frozen=True, eq=False)
class ParabolicLimits:
    """What each joint may do.

    Attributes:
        velocity: (n,) rad/s or m/s.
        acceleration: (n,) rad/s^2 or m/s^2.
        jerk: (n,) rad/s^3 or m/s^3.
        pause: s without acceleration between a ramp up and a ramp down.
    """

    velocity: Array
    acceleration: Array
    jerk: Array
    pause: float

    @classmethod
    def of(cls, limits: Limits) -> ParabolicLimits:
        """Limits for parabolic segments from the limits of a robot.

        The pause lasts as long as the slowest joint takes to build up its acceleration.

        Args:
            limits: Velocity, acceleration and jerk limits of the joints.

        Returns:
            The limits, with the pause rounded up to ticks.
        """
        ramp = float((limits.acceleration / limits.jerk).max())
        return cls(limits.velocity, limits.acceleration, limits.jerk, float(ticks_up(ramp)))


@dataclass(frozen=True, eq=False)
class ParabolicSegment:
    """Ramps of n joints in one common time, with a cruise in between.

    Attributes:
        q0: (n,) positions at the start.
        v0: (n,) velocities at the start.
        speed: (n,) velocities of the cruise.
        v1: (n,) velocities at the end.
        up: (n,) s from the start, in which the velocity changes from v0 to speed.
        down: (n,) s before the end, in which the velocity changes from speed to v1.
        duration: s.
    """

    q0: Array
    v0: Array
    speed: Array
    v1: Array
    up: Array
    down: Array
    duration: float

    @property
    def accelerations(self) -> tuple[Array, Array]:
        """(n,) each: accelerations of the first and of the last ramp."""
        return (
            (self.speed - self.v0) / np.where(self.up > 0.0, self.up, np.inf),
            (self.v1 - self.speed) / np.where(self.down > 0.0, self.down, np.inf),
        )

    def evaluate(self, t: Array) -> tuple[Array, Array]:
        """Positions and velocities at given times.

        Args:
            t: (M,) s since the segment began.

        Returns:
            Positions and velocities, (M, n) each.
        """
        first, last = self.accelerations
        t = np.asarray(t)[:, None]
        x, z = np.minimum(t, self.up), np.maximum(t - (self.duration - self.down), 0.0)
        missing = self.v0 - self.speed
        q = self.q0 + self.speed * t + x * (missing + first * x / 2) + last * z * z / 2
        return q, self.speed + missing + first * x + last * z

    def acceleration(self, t: Array) -> Array:
        """Accelerations at given times.

        Args:
            t: (M,) s since the segment began.

        Returns:
            (M, n) accelerations; at a switch either of its two values.
        """
        first, last = self.accelerations
        t = np.asarray(t)[:, None]
        return np.where(t < self.up, first, 0.0) + np.where(t > self.duration - self.down, last, 0.0)

    def state(self, t: float) -> JointState:
        """Positions and velocities at one time.

        Args:
            t: s since the segment began.

        Returns:
            The joint state.
        """
        q, v = self.evaluate(np.array([t]))
        return JointState(q[0], v[0])

    def part(self, start: float, end: float) -> ParabolicSegment:
        """Cut out a part of the segment.

        Args:
            start: s since the segment began.
            end: s since the segment began.

        Returns:
            The segment between the two times.
        """
        t = np.clip(self.up, start, end)
        down = end - np.clip(self.duration - self.down, start, end)
        here, there = self.state(start), self.state(end)
        speed = np.where(self.up > end, there.v, self.speed)
        speed = np.where(self.duration - self.down < start, here.v, speed)
        return ParabolicSegment(here.q, here.v, speed, there.v, t - start, down, end - start)


def resting_segment(q: Array, duration: float) -> ParabolicSegment:
    """A segment in which nothing moves.

    Args:
        q: (n,) configuration.
        duration: s.

    Returns:
        The segment at rest.
    """
    none = np.zeros(len(q))
    return ParabolicSegment(q, none, none, none, none, none, duration)


def straight_segment(q0: Array, q1: Array, pace: ParabolicLimits) -> ParabolicSegment:
    """The fastest segment along the straight line, from rest to rest: all joints ramp at once.

    Args:
        q0: (n,) start.
        q1: (n,) end.
        pace: Velocity and acceleration limits, and the pause.

    Returns:
        The segment.
    """
    way = np.maximum(np.abs(q1 - q0), _NOTHING)
    top, hard = float((pace.velocity / way).min()), float((pace.acceleration / way).min())
    # With the pause as cruise: top^2 / hard + top * pause = 1.
    top = min(top, (np.sqrt((hard * pace.pause) ** 2 + 4 * hard) - hard * pace.pause) / 2)
    up = float(ticks_up(top / hard))
    cruise = float(ticks_up(1 / top - top / hard))
    speed, ramps, none = (q1 - q0) / (up + cruise), np.full(len(q0), up), np.zeros(len(q0))
    return ParabolicSegment(q0, none, speed, none, ramps, ramps, 2 * up + cruise)


def ticks_up(t: Array | float) -> Array:
    """Round times up to whole ticks, but for rounding errors.

    Args:
        t: Times of any shape, s.

    Returns:
        The rounded times, s.
    """
    return np.asarray(np.ceil(t / TICK - 1e-6) * TICK)
