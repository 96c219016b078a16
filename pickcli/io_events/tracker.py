"""Event tracker: fires events by the measured position on the path, not by the clock.

Progress is the trajectory's time of the path point nearest to the measured configuration. It is searched in a
short window ahead of the current progress, so it never decreases, and a path that crosses itself or passes
the same place twice is not ambiguous. If a robot lags, pauses or runs slower, progress and events are delayed
with it. During rests of the trajectory, and just before them, where the motion is very slow, positions do not
determine the time: once the robot is near a rest, progress advances with the elapsed time.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence

import numpy as np

from pickcli.geometry import Array
from pickcli.motion.event import Event
from pickcli.motion.segment import Segment
from pickcli.motion.trajectory import Trajectory

SPACING = 4e-3  # s between the stored points of the path
WINDOW = 0.02  # s of the trajectory that one update may advance, in addition to 2 dt
# joint units along the path (0.5 mm at 1 m from a joint): this near to a rest, the clock is used
NEAR_REST = 5e-4
LEFT_REST = 1e-3  # joint units along the path beyond which the robot has left a rest
MAX_RATE = 1.5  # largest rate of progress that is used to extrapolate the next step
TIME_ROUNDING = 1e-9  # s by which equal times may differ


class EventTracker:
    """Follows one execution of a trajectory and fires every event once, in the order of the triggers.

    Args:
        trajectory: The timed motion.
        segments: Its segments.
        events: Its events, resolved.
        weights: (n,) of the joints in the distance between configurations; 1 by default, so that a metre of a
            prismatic joint counts like a radian.

    Raises:
        ValueError: If an event is not resolved.
    """

    def __init__(
        self,
        trajectory: Trajectory,
        segments: Sequence[Segment],
        events: Sequence[Event],
        weights: Array | None = None,
    ) -> None:
        unresolved = [event for event in events if event.t_trigger is None]
        if unresolved:
            raise ValueError(
                f"{unresolved[0].device} {unresolved[0].action} has no trigger time: resolve events first"
            )
        self._segments = tuple(segments)
        self._triggers = sorted(
            ((event.t_trigger, event) for event in events if event.t_trigger is not None),
            key=lambda pair: pair[0],
        )
        self._weights = (
            np.ones(trajectory.positions.shape[1]) if weights is None else np.asarray(weights, dtype=float)
        )
        self._times, points, rests = _path(trajectory)
        self._points = points * self._weights
        self._steps = np.diff(self._points, axis=0)
        squared = np.einsum("ij,ij->i", self._steps, self._steps)
        self._inverse = 1.0 / np.maximum(squared, 1e-18)
        self._travel: list[float] = [0.0, *np.cumsum(np.sqrt(squared)).tolist()]
        # The end counts as a rest without end.
        self._rests = [*rests, len(self._times) - 1]
        self._progress, self._piece, self._n_fired = 0.0, 0, 0

    @property
    def progress(self) -> float:
        """Time on the trajectory (s) that the robot has reached; beyond the end while it rests there."""
        return self._progress

    @property
    def segment(self) -> int:
        """Index of the robot's current segment."""
        ends = [segment.t_end for segment in self._segments]
        return min(bisect_left(ends, self._progress), max(len(ends) - 1, 0))

    @property
    def pending(self) -> tuple[Event, ...]:
        """Events that have not fired, in order."""
        return tuple(event for _, event in self._triggers[self._n_fired :])

    def update(self, q: Array, dt: float = 1e-3) -> tuple[Event, ...]:
        """Process a measurement, and fire the events that are due.

        An event fires at the step nearest to its trigger: half a step early if the rate of the last step
        predicts that the next one would be farther past it. Events of a rest do not fire before the robot is
        near the rest.

        Args:
            q: (n,) measured configuration.
            dt: s since the last update.

        Returns:
            Events that are due, in order.
        """
        before = self._progress
        here = self._weights * q
        rest = self._next_rest()
        if self._is_near(rest) and self._has_left(rest, here):
            self._piece, self._progress = rest + 1, self._times[rest + 1]
            rest = self._next_rest()
        is_near = self._is_near(rest)
        if is_near:
            self._wait(rest, dt)
        else:
            self._follow(rest, here, dt)
        rate = min((self._progress - before) / dt, MAX_RATE) if dt > 0.0 else 0.0
        due = self._progress + 0.5 * rate * dt
        if not is_near:
            due = min(due, np.nextafter(self._times[rest], -1.0))
        return self._fire(due)

    def _next_rest(self) -> int:
        """Return the index of the point at which the current or next rest begins."""
        return self._rests[bisect_left(self._rests, self._piece)]

    def _is_near(self, rest: int) -> bool:
        """Whether the robot rests, or its remaining path to the rest is too short to determine the time."""
        times, travel, piece = self._times, self._travel, self._piece
        if piece >= rest:
            return True
        share = (self._progress - times[piece]) / (times[piece + 1] - times[piece])
        return travel[rest] - travel[piece] - share * (travel[piece + 1] - travel[piece]) <= NEAR_REST

    def _follow(self, rest: int, q: Array, dt: float) -> None:
        """Advance the progress by projection, at most to the rest."""
        times, start = self._times, self._piece
        end = min(bisect_left(times, self._progress + WINDOW + 2.0 * dt), rest)
        begun = (self._progress - times[start]) / (times[start + 1] - times[start])
        share, piece = self._nearest(start, max(end, start + 1), begun, q)
        self._piece = piece
        self._progress = times[piece] + share * (times[piece + 1] - times[piece])

    def _has_left(self, rest: int, q: Array) -> bool:
        """Whether the robot moves out of a rest that has not ended by the clock.

        It arrived late, or was commanded earlier: the remaining rest is skipped.
        """
        if rest + 1 >= len(self._times) - 1:
            return False
        end = bisect_left(self._travel, self._travel[rest + 1] + 3.0 * LEFT_REST, lo=rest + 2)
        end = min(end, len(self._times) - 1)
        share, piece = self._nearest(rest + 1, end, 0.0, q)
        gone = self._travel[piece] + share * (self._travel[piece + 1] - self._travel[piece])
        return gone - self._travel[rest + 1] > LEFT_REST

    def _nearest(self, start: int, end: int, begun: float, q: Array) -> tuple[float, int]:
        """Return share and index of the piece in [start, end) nearest to q; the first from ``begun`` on."""
        away = q - self._points[start:end]
        steps = self._steps[start:end]
        u = np.einsum("ij,ij->i", away, steps) * self._inverse[start:end]
        u = np.minimum(np.maximum(u, 0.0), 1.0)
        u[0] = max(u[0], begun)
        away -= u[:, None] * steps
        nearest = int(np.einsum("ij,ij->i", away, away).argmin())
        return float(u[nearest]), start + nearest

    def _wait(self, rest: int, dt: float) -> None:
        """Advance with the elapsed time at a rest, or just before it."""
        self._progress += dt
        last = min(rest + 1, len(self._times) - 1)
        while self._piece < last and self._progress >= self._times[self._piece + 1]:
            self._piece += 1

    def _fire(self, due: float) -> tuple[Event, ...]:
        first = self._n_fired
        while self._n_fired < len(self._triggers) and self._triggers[self._n_fired][0] <= due + TIME_ROUNDING:
            self._n_fired += 1
        return tuple(event for _, event in self._triggers[first : self._n_fired])


def _path(trajectory: Trajectory) -> tuple[list[float], Array, list[int]]:
    """Return times and points (M, n) at most ``SPACING`` apart, and the indices at which rests begin.

    A rest of any duration is one piece between two equal points.
    """
    q, t = trajectory.positions, trajectory.times
    still = np.all(trajectory.velocities == 0.0, axis=1) & np.all(trajectory.accelerations == 0.0, axis=1)
    is_rest = np.all(q[1:] == q[:-1], axis=1) & still[1:] & still[:-1]
    counts = np.where(is_rest, 1, np.ceil(np.diff(t) / SPACING - TIME_ROUNDING)).astype(int)
    at = np.concatenate([[0], np.cumsum(counts)])  # index of every original point among the new ones
    times = np.interp(np.arange(at[-1] + 1), at, t)
    return times.tolist(), trajectory.sample(times), at[:-1][is_rest].tolist()
