"""A leg: every joint ramps to a speed of its own, keeps it, and ramps to its last speed, all in one time.

The joints start and end together and are otherwise independent, so only the slowest one needs its limits; the
others have time to spare (Hauser and Ng-Thow-Hing 2010, with the speeds of all joints free at both ends).
Ramps begin and end on ticks: with that, what becomes of the legs later has no switch between two ticks.
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
    """Where the joints are and how fast: (n,) each."""

    q: Array
    v: Array

    @classmethod
    def at_rest(cls, q: Array) -> JointState:
        """Standing."""
        return cls(q, np.zeros(len(q)))


@dataclass(frozen=True, eq=False)
class ParabolicLimits:
    """What a joint may do: (n,) each. pause: s of no acceleration between a ramp up and a ramp down."""

    velocity: Array
    acceleration: Array
    jerk: Array
    pause: float

    @classmethod
    def of(cls, limits: Limits) -> ParabolicLimits:
        """Of limits: the pause lasts as long as building up the acceleration of the slowest joint does."""
        ramp = float((limits.acceleration / limits.jerk).max())
        return cls(limits.velocity, limits.acceleration, limits.jerk, float(ticks_up(ramp)))


@dataclass(frozen=True, eq=False)
class ParabolicSegment:
    """Ramps of (n,) joints in ``duration`` s: v0 to speed in ``up`` s, speed to v1 in the last ``down`` s."""

    q0: Array
    v0: Array
    speed: Array
    v1: Array
    up: Array
    down: Array
    duration: float

    @property
    def accelerations(self) -> tuple[Array, Array]:
        """(n,) each: of the first and of the last ramp."""
        return (
            (self.speed - self.v0) / np.where(self.up > 0.0, self.up, np.inf),
            (self.v1 - self.speed) / np.where(self.down > 0.0, self.down, np.inf),
        )

    def evaluate(self, t: Array) -> tuple[Array, Array]:
        """Positions and velocities (M, n) at times t (M,) within the leg."""
        first, last = self.accelerations
        t = np.asarray(t)[:, None]
        x, z = np.minimum(t, self.up), np.maximum(t - (self.duration - self.down), 0.0)
        missing = self.v0 - self.speed
        q = self.q0 + self.speed * t + x * (missing + first * x / 2) + last * z * z / 2
        return q, self.speed + missing + first * x + last * z

    def acceleration(self, t: Array) -> Array:
        """(M, n) at times t (M,); either value at a switch."""
        first, last = self.accelerations
        t = np.asarray(t)[:, None]
        return np.where(t < self.up, first, 0.0) + np.where(t > self.duration - self.down, last, 0.0)

    def state(self, t: float) -> JointState:
        """The joints at time t."""
        q, v = self.evaluate(np.array([t]))
        return JointState(q[0], v[0])

    def part(self, start: float, end: float) -> ParabolicSegment:
        """The leg between two of its times."""
        t = np.clip(self.up, start, end)
        down = end - np.clip(self.duration - self.down, start, end)
        here, there = self.state(start), self.state(end)
        speed = np.where(self.up > end, there.v, self.speed)
        speed = np.where(self.duration - self.down < start, here.v, speed)
        return ParabolicSegment(here.q, here.v, speed, there.v, t - start, down, end - start)


def resting_segment(q: Array, duration: float) -> ParabolicSegment:
    """Standing for a while."""
    none = np.zeros(len(q))
    return ParabolicSegment(q, none, none, none, none, none, duration)


def straight_segment(q0: Array, q1: Array, pace: ParabolicLimits) -> ParabolicSegment:
    """The fastest way along the straight line, from rest to rest: all joints ramp at once."""
    way = np.maximum(np.abs(q1 - q0), _NOTHING)
    top, hard = float((pace.velocity / way).min()), float((pace.acceleration / way).min())
    # With the pause as cruise: top^2 / hard + top * pause = 1.
    top = min(top, (np.sqrt((hard * pace.pause) ** 2 + 4 * hard) - hard * pace.pause) / 2)
    up = float(ticks_up(top / hard))
    cruise = float(ticks_up(1 / top - top / hard))
    speed, ramps, none = (q1 - q0) / (up + cruise), np.full(len(q0), up), np.zeros(len(q0))
    return ParabolicSegment(q0, none, speed, none, ramps, ramps, 2 * up + cruise)


def ticks_up(t: Array | float) -> Array:
    """Times rounded up to ticks, but for rounding errors."""
    return np.asarray(np.ceil(t / TICK - 1e-6) * TICK)
