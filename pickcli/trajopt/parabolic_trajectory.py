"""Parabolic trajectories: segments that are cut, joined and turned into what a checker can prove."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.geometry import Array
from pickcli.trajopt.parabolic_segment import TICK, JointState, ParabolicLimits, ParabolicSegment

_WINDOWS = 6  # from a pause to two, that are tried
_ROUNDING = 1e-9


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

    def total(self, pace: ParabolicLimits) -> float:
        """Duration once the jerk limits are kept.

        Args:
            pace: Limits that give the jerk window.

        Returns:
            s, the jerk window included.
        """
        return self.duration + jerk_window(self.segments, pace)

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
        slacks.append(bend * (t[1] - t[0]) ** 2 / 8)
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


def jerk_window(segments: tuple[ParabolicSegment, ...], pace: ParabolicLimits) -> float:
    """Time over which segments must be averaged to keep the jerk limits: a pause, or up to two.

    The jerk of an average over w s is the change of acceleration in w s, over w. Over two pauses it keeps the
    limit whatever the segments do; over one, unless a joint turns from ramp to ramp.

    Args:
        segments: Segments, one after the other.
        pace: Acceleration and jerk limits, and the pause.

    Returns:
        s, a whole number of ticks.
    """
    ticks = round(pace.pause / TICK)
    if np.all(2 * pace.acceleration <= pace.jerk * pace.pause * (1.0 + _ROUNDING)):
        return ticks * TICK
    a = np.pad(accelerations(segments), ((2 * ticks, 2 * ticks), (0, 0)))
    for n in np.linspace(ticks, 2 * ticks, _WINDOWS).round().astype(int):
        if np.all(np.abs(a[n:] - a[:-n]) <= pace.jerk * (n * TICK * (1.0 + _ROUNDING))):
            break
    return int(n) * TICK
