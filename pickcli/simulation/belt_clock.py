"""The time of a plan for a running conveyor, as the belt's own travel tells it: the clock is the encoder.

While the arm follows the belt, the plan is where it would be at the travel that the encoder measures: a belt
that slows down or stops takes the arm along, on the path that was proven, and costs nothing but time. Before,
the plan runs by the clock, and waits where the axis begins to follow the belt. After the item is off the
belt, the plan returns to the clock.

Only the deviation of the travel from that of the plan's speed is filtered, by three first-order lags whose
delay is made up for by the rate of the deviation, so that a steady belt is followed without an error, and
counts of the encoder do not shake the axis.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np

from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind

LAG_RATE = 25.0  # 1/s of each lag: 1 mm off a belt that changes its speed at 0.2 m/s2
MOST_PACE = 1.1  # of the plan's time: its lines have room for that
RETURN_TIME = 0.6  # s in which the plan returns from the belt to the clock
AT_REST = 1e-9  # rad/s or m/s of every joint


@runtime_checkable
class BeltEncoder(Protocol):
    """A driver that measures the travel of conveyors."""

    def belt_travel(self, conveyor: str) -> float | None:
        """Return the measured travel of a conveyor.

        Args:
            conveyor: Name of the conveyor.

        Returns:
            m since it was first measured; None if it stands.
        """

    def encoder_latency(self, conveyor: str) -> float:
        """Return by how much a reading is old.

        Args:
            conveyor: Name of the conveyor.

        Returns:
            s.
        """


class BeltClock:
    """Follows one execution of a plan.

    Args:
        plan: The plan, with a conveyor.
        encoder: Measures the travel.
        time_step: s between two set points.

    Attributes:
        t_follows: s of the plan from which the arm follows the belt.
        t_left: s of the plan at which the item is off the belt.
    """

    def __init__(self, plan: Plan, encoder: BeltEncoder, time_step: float) -> None:
        assert plan.tracking is not None
        self._conveyor, self._speed = plan.tracking.conveyor, plan.tracking.speed
        self._encoder, self._time_step = encoder, time_step
        self.t_follows, self.t_left = _followed(plan)
        self._t = -encoder.encoder_latency(self._conveyor)  # s since the start, of the next reading
        self._start = encoder.belt_travel(self._conveyor) or 0.0
        self._start -= self._speed * self._t  # it is where the belt was
        self._lags, self._belt = np.zeros(3), 0.0
        self._t_returning = 0.0

    def next(self, t_plan: float) -> float:
        """Return the time of the plan at the next set point.

        Args:
            t_plan: s of the plan at the last one.

        Returns:
            s of the plan; a little before the last where a belt stops sooner than was estimated.
        """
        step, before, belt = self._time_step, self._belt, self._belt_time() + self._time_step
        self._belt = belt
        if t_plan + step < self.t_follows:
            return t_plan + step
        if t_plan < self.t_left:
            return max(self.t_follows, min(belt, t_plan + MOST_PACE * step))
        share = min(1.0, self._t_returning / RETURN_TIME)
        share *= share * (3.0 - 2.0 * share)
        self._t_returning += step
        return t_plan + (1.0 - share) * min(max(belt - before, 0.0), MOST_PACE * step) + share * step

    def _belt_time(self) -> float:
        """S of the plan at which its belt would be where the belt is now."""
        step = self._time_step
        travel = (self._encoder.belt_travel(self._conveyor) or 0.0) - self._start
        before = travel - self._speed * self._t
        for k in range(3):
            self._lags[k] += step * LAG_RATE * (before - self._lags[k])
            before = self._lags[k]
        latency = self._encoder.encoder_latency(self._conveyor)
        ahead = (3.0 + LAG_RATE * latency) * float(self._lags[1] - self._lags[2])
        now = self._t + latency
        self._t += step
        return now + (float(self._lags[2]) + ahead) / self._speed


def _followed(plan: Plan) -> tuple[float, float]:
    """S from which the axis follows the belt: where the arm last rests before the lines; s of its leaving."""
    contact = next(s for s in plan.segments if s.kind is SegmentKind.CONTACT)
    lines = next(s.t_start for s in plan.segments if s.kind is not SegmentKind.TRANSIT)
    left = next(
        s.t_start for s in plan.segments if s.kind is SegmentKind.TRANSFER and s.t_start >= contact.t_end
    )
    times, speeds = plan.trajectory.times, np.abs(plan.trajectory.velocities).max(axis=1)
    return float(times[(times < lines) & (speeds <= AT_REST)].max(initial=0.0)), left
