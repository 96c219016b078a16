"""Parabolic segments in numpy, all joints at once: what the kernel is compared with, to the last bit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array

TICK = 0.001  # s

_NOTHING = 1e-12  # m or rad, per s: what counts as none
_ROUNDING = 1e-9  # relative: how far beyond a limit rounding may lead
_EXTRA = (0, 1, 2, 4, 8, 16, 32)  # ticks added in turn where another joint has no segment just then
_WINDOWS = 6  # from a pause to two, that are tried


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


def ticks_up(t: Array | float) -> Array:
    """Round times up to whole ticks, except for rounding errors.

    Args:
        t: Times of any shape, s.

    Returns:
        The rounded times, s.
    """
    return np.asarray(np.ceil(t / TICK - 1e-6) * TICK)


@dataclass(frozen=True, eq=False)
class ParabolicTrajectory:
    """Parabolic segments, each beginning as the one before it ends; at rest at both ends.

    Accelerations jump between the segments and inside them; ``filter_jerk`` makes a trajectory with limited
    jerk of it.

    Attributes:
        segments: The segments, in their order.
    """

    segments: tuple[ParabolicSegment, ...]

    @cached_property
    def starts(self) -> Array:
        """(L + 1,) s: when each segment begins, and the end."""
        durations = [segment.duration for segment in self.segments]
        return np.rint(np.cumsum([0.0, *durations]) / TICK) * TICK

    @property
    def duration(self) -> float:
        """Duration from rest to rest, s, before jerk is limited."""
        return float(self.starts[-1])

    def total(self, limits: ParabolicLimits) -> float:
        """Duration once the jerk limits are kept.

        Args:
            limits: Limits that give the jerk window.

        Returns:
            s, the jerk window included.
        """
        return self.duration + jerk_window(self.segments, limits)

    def state(self, t: float) -> JointState:
        """Positions and velocities at one time.

        Args:
            t: s since the start.

        Returns:
            The joint state.
        """
        k = self._leg(t)
        return self.segments[k].state(t - float(self.starts[k]))

    def between(self, start: float, end: float) -> tuple[ParabolicSegment, ...]:
        """The segments between two times.

        Args:
            start: s since the start, on a tick.
            end: s since the start, on a tick.

        Returns:
            The segments, cut where the times fall into them.
        """
        parts = []
        for segment, begin in zip(self.segments, self.starts, strict=False):
            low, high = max(start - begin, 0.0), min(end - begin, segment.duration)
            if high - low > TICK / 2:
                is_whole = low < TICK / 2 and high > segment.duration - TICK / 2
                parts.append(segment if is_whole else segment.part(low, high))
        return tuple(parts)

    def replaced(
        self, start: float, end: float, segments: tuple[ParabolicSegment, ...]
    ) -> ParabolicTrajectory:
        """The trajectory with other segments between two times.

        Args:
            start: s since the start, on a tick.
            end: s since the start, on a tick.
            segments: Segments that lead from the state at ``start`` to the state at ``end``.

        Returns:
            The changed trajectory.
        """
        return ParabolicTrajectory(self.between(0.0, start) + segments + self.between(end, self.duration))

    def _leg(self, t: float) -> int:
        return int(np.clip(np.searchsorted(self.starts, t, side="right") - 1, 0, len(self.segments) - 1))


def tube(segments: tuple[ParabolicSegment, ...], step: float) -> tuple[Array, Array]:
    """Chords of segments, and how far the segments leave them.

    A curve of acceleration a leaves a chord of h s by a h^2 / 8 at most.

    Args:
        segments: Segments, one after the other.
        step: Longest chord, s.

    Returns:
        Chord ends (K, n) and slack (K - 1, n): on each chord the motion stays within the slack, joint by
        joint.
    """
    rows, slacks = [], []
    for segment in segments:
        t = np.linspace(0.0, segment.duration, int(np.ceil(segment.duration / step - 1e-9)) + 1)
        first, last = segment.accelerations
        bend = np.maximum(
            np.where(t[:-1, None] < segment.up, np.abs(first), 0.0),
            np.where(t[1:, None] > segment.duration - segment.down, np.abs(last), 0.0),
        )
        slacks.append(bend * ((t[1] - t[0]) * (t[1] - t[0])) / 8)
        rows.append(segment.evaluate(t if segment is segments[-1] else t[:-1])[0])
    return np.concatenate(rows), np.concatenate(slacks)


def accelerations(segments: tuple[ParabolicSegment, ...]) -> Array:
    """Accelerations of segments during each tick.

    Args:
        segments: Segments, one after the other.

    Returns:
        (K, n), a row for each of K ticks.
    """
    return np.concatenate(
        [
            segment.acceleration(TICK * (np.arange(float(round(segment.duration / TICK))) + 0.5))
            for segment in segments
        ]
    )


def jerk_window(segments: tuple[ParabolicSegment, ...], limits: ParabolicLimits) -> float:
    """Time over which segments must be averaged to keep the jerk limits: a pause, or up to two.

    The jerk of an average over w s is the change of acceleration in w s, over w. Over two pauses it keeps the
    limit whatever the segments do; over one, unless a joint turns from ramp to ramp.

    Args:
        segments: Segments, one after the other.
        limits: Acceleration and jerk limits, and the pause.

    Returns:
        s, a whole number of ticks.
    """
    ticks = round(limits.pause / TICK)
    if np.all(2 * limits.acceleration <= limits.jerk * limits.pause * (1.0 + _ROUNDING)):
        return ticks * TICK
    a = np.pad(accelerations(segments), ((2 * ticks, 2 * ticks), (0, 0)))
    for n in np.linspace(ticks, 2 * ticks, _WINDOWS).round().astype(int):
        if np.all(np.abs(a[n:] - a[:-n]) <= limits.jerk * (n * TICK * (1.0 + _ROUNDING))):
            break
    return int(n) * TICK


def steer_min_time(
    start: JointState, end: JointState, limits: ParabolicLimits, at_most: float
) -> ParabolicSegment | None:
    """The segment of least time between two states.

    Args:
        start: State in which it begins.
        end: State in which it ends.
        limits: Velocity and acceleration limits, and the pause.
        at_most: Longest duration that is wanted, s.

    Returns:
        The segment; None if it takes longer than ``at_most``, or if a joint has no segment of any of the
        times tried.
    """
    least = float(ticks_up(least_time(end.q - start.q, start.v, end.v, limits).max()))
    for extra in _EXTRA:
        duration = max(least, TICK) + extra * TICK
        if duration > at_most + TICK / 2:
            return None
        segment = steer_fixed_time(start, end, limits, duration)
        if segment is not None:
            return segment
    return None


def least_time(d: Array, v0: Array, v1: Array, limits: ParabolicLimits) -> Array:
    """Time that each joint needs alone, with full ramps and the pause in between.

    Args:
        d: (n,) distances, rad or m.
        v0: (n,) velocities at the start.
        v1: (n,) velocities at the end.
        limits: Velocity and acceleration limits, and the pause.

    Returns:
        (n,) s.
    """
    a, top = limits.acceleration, limits.velocity
    beyond = d - (v0 + v1) / 2 * np.abs(v1 - v0) / a  # what a single ramp from v0 to v1 leaves
    sign = np.where(beyond < 0.0, -1.0, 1.0)
    d, v0, v1, beyond = sign * d, sign * v0, sign * v1, sign * beyond
    half = a * limits.pause / 2
    peak = np.sqrt(np.maximum(half * half + a * d + (v0 * v0 + v1 * v1) / 2, 0.0)) - half
    faster = np.maximum(v0, v1)
    peak = np.minimum(np.maximum(peak, faster), top)
    cruised = d - (2 * peak * peak - v0 * v0 - v1 * v1) / (2 * a)
    cruise = np.where(np.abs(peak) > _NOTHING, cruised / np.where(peak == 0.0, 1.0, peak), 0.0)
    return np.asarray((2 * peak - v0 - v1) / a + np.maximum(cruise, 0.0))


def steer_fixed_time(
    start: JointState, end: JointState, limits: ParabolicLimits, duration: float
) -> ParabolicSegment | None:
    """The segment of a given duration between two states.

    Args:
        start: State in which it begins.
        end: State in which it ends.
        limits: Velocity and acceleration limits, and the pause.
        duration: s, a whole number of ticks.

    Returns:
        The segment, or None if a joint has none of that duration.
    """
    speed, up, down, is_good = _calm_ramps(end.q - start.q, start.v, end.v, limits, duration)
    return ParabolicSegment(start.q, start.v, speed, end.v, up, down, duration) if is_good.all() else None


def steer_via(
    start: JointState,
    middles: Sequence[JointState],
    end: JointState,
    limits: ParabolicLimits,
    there: float,
    back: float,
) -> tuple[ParabolicSegment, ParabolicSegment] | None:
    """Two segments by way of a state in between, which every joint chooses on its own.

    Every joint takes the first of the middle states for which it has both segments.

    Args:
        start: State in which the first segment begins.
        middles: States to choose from, the preferred first.
        end: State in which the second segment ends.
        limits: Velocity and acceleration limits, and the pause.
        there: Duration of the first segment, s.
        back: Duration of the second segment, s.

    Returns:
        Both segments, or None if a joint has no choice.
    """
    q, v = np.stack([middle.q for middle in middles]), np.stack([middle.v for middle in middles])
    *first, is_there = _calm_ramps(q - start.q, start.v, v, limits, there)
    *last, is_back = _calm_ramps(end.q - q, v, end.v, limits, back)
    is_good = is_there & is_back
    if not is_good.any(axis=0).all():
        return None
    pick = is_good.argmax(axis=0), np.arange(len(start.q))
    speed, up, down = (row[pick] for row in first)
    onward = (row[pick] for row in last)
    return (
        ParabolicSegment(start.q, start.v, speed, v[pick], up, down, there),
        ParabolicSegment(q[pick], v[pick], next(onward), end.v, next(onward), next(onward), back),
    )


def _calm_ramps(
    d: Array, v0: Array, v1: Array, limits: ParabolicLimits, duration: float
) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """``_ramps`` with half of the acceleration where a joint can, else with all of it.

    With half, no jerk limit minds a ramp up next to a ramp down; and it is calmer.
    """
    *calm, is_calm = _ramps(d, v0, v1, limits, 0.5, duration, 0.0)
    if is_calm.all():
        return calm[0], calm[1], calm[2], is_calm
    *hard, is_hard = _ramps(d, v0, v1, limits, 1.0, duration, limits.pause)
    speed, up, down = (np.where(is_calm, a, b) for a, b in zip(calm, hard, strict=True))
    return speed, up, down, is_calm | is_hard


def _ramps(
    d: Array, v0: Array, v1: Array, limits: ParabolicLimits, share: float, duration: float, pause: float
) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
    """Speed, up and down (..., n) with a share of the acceleration, and where that keeps the limits.

    The distance grows with the speed in between, so there is one speed for every distance: linear where it
    lies between v0 and v1, else the root of a quadratic, and linear again once ramps are rounded to ticks.
    """
    a = share * limits.acceleration
    ramp = np.abs(v1 - v0) / a
    total = v0 + v1
    between = (d - total / 2 * ramp) / np.maximum(duration - ramp, _NOTHING)
    sign = np.where(between > np.maximum(v0, v1), 1.0, -1.0)
    is_between = (between <= np.maximum(v0, v1)) & (between >= np.minimum(v0, v1))
    b = duration + sign * total / a
    root = b * b - 4 / a * ((v0 * v0 + v1 * v1) / (2 * a) + sign * d)
    speed = np.where(is_between, between, sign * a / 2 * (b - np.sqrt(np.maximum(root, 0.0))))
    for _ in range(2):
        up, down = _ramp_times(speed - v0, a), _ramp_times(v1 - speed, a)
        speed = (d - (v0 * up + v1 * down) / 2) / np.maximum(duration - (up + down) / 2, TICK)
    first, last = speed - v0, v1 - speed
    cruise = duration - up - down
    slack = _ROUNDING * limits.velocity
    is_good = (
        (np.abs(first) <= a * up + slack * (up > 0.0) + _NOTHING)
        & (np.abs(last) <= a * down + slack * (down > 0.0) + _NOTHING)
        & (np.abs(speed) <= limits.velocity + slack)
        & (cruise >= np.where(first * last < 0.0, pause, 0.0) - TICK / 2)
    )
    return speed, up, down, is_good


def _ramp_times(change: Array, acceleration: Array) -> Array:
    """Whole ticks for changes of speed: at least one where the speed changes."""
    change = np.abs(change)
    return np.maximum(ticks_up(change / acceleration), np.where(change > _NOTHING, TICK, 0.0))


def positions(segments: tuple[ParabolicSegment, ...], times: Array) -> Array:
    """Positions (M, n) at times (M,), s since the first of the segments began."""
    ends = np.cumsum([segment.duration for segment in segments])
    # A time at the end is the last segment's.
    of = np.minimum(ends.searchsorted(times, side="right"), len(segments) - 1)
    return np.concatenate(
        [
            segment.evaluate(times[of == k] - (ends[k] - segment.duration))[0]
            for k, segment in enumerate(segments)
        ]
    )
