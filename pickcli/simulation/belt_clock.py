"""The time of a plan for a running conveyor, as the belt's own travel tells it: the clock is the encoder.

Until the item is off the belt, the plan is where it would be at the travel that the encoder measures: a belt
that slows down or stops takes the arm along, on the path that was proven. After that, wherever the belt
carries what rides on it is proven, too, and the plan returns to the clock of the controller. The rate of the
plan's time changes as quickly as the limits of the joints allow. A belt from which the plan has strayed by
more than its proof allows is told.

Only the deviation of the travel from that of the plan's speed is filtered, by three first-order lags whose
delay is made up for by the rate of the deviation, so that a steady belt is followed without an error, and
counts of the encoder do not shake the axis.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol, runtime_checkable

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.motion.plan import Plan, times_at_work
from pickcli.simulation.online_time_scaling import OnlineTimeScaling
from pickcli.timing.line_tracking import MOST_PACE

LAG_RATE = 25.0  # 1/s of each lag: 1 mm off a belt that changes its speed at 0.2 m/s2
CATCH_UP = 10.0  # 1/s at which the plan makes up for time that it is behind the belt, or ahead of it
COMING_CHANGE = 0.6  # 1/s of the pace while the whole arm moves: a belt that changes by 0.2 m/s2 at 0.33 m/s
WAITED = 0.01  # s that the plan waits for the belt at least, where it begins to follow it
AT_REST = 1e-9  # rad/s or m/s of every joint


@runtime_checkable
class BeltEncoder(Protocol):
    """A driver that measures the travel of conveyors."""

    def belt_travel(self, conveyor: str) -> float | None:
        """Return the measured travel of a conveyor.

        Args:
            conveyor: Name of the conveyor.

        Returns:
            m since it was first measured; None if it is not measured, as of a belt that stands all the time.
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
        cell: Its cell.
        encoder: Measures the travel.
        time_step: s between two set points.

    Attributes:
        t_follows: s of the plan from which the axis follows the belt: where the arm last rests before.
        t_left: s of the plan at which the item is off the belt.
        off: m by which the belt is ahead of the plan, negative if it is behind.
        allowed: m by which it may be behind, as a negative number, and ahead.
    """

    def __init__(self, plan: Plan, cell: Cell, encoder: BeltEncoder, time_step: float) -> None:
        assert plan.tracking is not None
        conveyor = cell.carriers[plan.tracking.conveyor].conveyor
        assert conveyor is not None
        self._tracking, self._most_speed = plan.tracking, conveyor.max_speed
        self._times = times_at_work(plan.segments)
        self._encoder, self._time_step = encoder, time_step
        limits = cell.robot.limits
        scaled = replace(limits, acceleration=cell.speed_scale * limits.acceleration)
        self._scaling = OnlineTimeScaling(plan.trajectory, scaled, time_step)
        times, speeds = plan.trajectory.times, np.abs(plan.trajectory.velocities).max(axis=1)
        is_before = times < self._times[0]
        self.t_follows = float(times[is_before & (speeds <= AT_REST)].max(initial=0.0))
        self.t_left = self._times[1]
        speed = self._tracking.speed
        self._latency = encoder.encoder_latency(self._tracking.conveyor)
        self._last = 0.0  # m, last reading
        self._t = -self._latency  # s since the start, of the next reading
        self._start = self._reading() - speed * self._t  # where the belt was at the start
        self._lags, self._belt = np.zeros(3), 0.0
        self.off, self.allowed = 0.0, (0.0, 0.0)

    @property
    def is_off(self) -> bool:
        """Whether the plan has strayed from the belt by more than its proof allows."""
        return not self.allowed[0] <= self.off <= self.allowed[1]

    def next(self) -> float:
        """Return the time of the plan at the next set point.

        Returns:
            s of the plan.
        """
        scaling, before = self._scaling, self._belt
        waits = scaling.t <= self.t_follows
        travel = self._reading() - self._start
        self._belt = self._belt_time(travel) + self._time_step
        if scaling.t >= self.t_left:
            wanted = 1.0
        else:
            rate = (self._belt - before) / self._time_step
            most = 1.0 if waits else MOST_PACE
            wanted = min(max(rate + CATCH_UP * (before - scaling.t), 0.0), most)
        t = scaling.advance(wanted, COMING_CHANGE if waits else np.inf)
        if waits and t > self.t_follows and self._belt < t - WAITED:
            t = scaling.hold(max(self.t_follows, self._belt))
        behind, ahead = self._tracking.off_by(np.array([t]), self._times, self._most_speed)
        self.allowed = -float(behind[0]), float(ahead[0])
        self.off = travel - self._tracking.speed * (t - scaling.rate * (self._latency + self._time_step))
        return t

    def stopping(self) -> float:
        """Return the time of the plan at the next set point of a stop, as quick as the limits allow.

        Returns:
            s of the plan.
        """
        return self._scaling.advance(0.0, self._scaling.bearable_change)

    @property
    def rate(self) -> float:
        """Rate of the plan's time at the last set point."""
        return self._scaling.rate

    def _reading(self) -> float:
        """M by the encoder."""
        travel = self._encoder.belt_travel(self._tracking.conveyor)
        self._last = self._last if travel is None else travel
        return self._last

    def _belt_time(self, travel: float) -> float:
        """S of the plan at which its belt would be where the belt is now."""
        step, speed = self._time_step, self._tracking.speed
        before = travel - speed * self._t
        for k in range(3):
            self._lags[k] += step * LAG_RATE * (before - self._lags[k])
            before = self._lags[k]
        ahead = (3.0 + LAG_RATE * self._latency) * float(self._lags[1] - self._lags[2])
        now = self._t + self._latency
        self._t += step
        return now + (float(self._lags[2]) + ahead) / speed
