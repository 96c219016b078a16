"""The time of a plan for a running conveyor, as the belt's own travel tells it: the clock is the encoder.

Until the item is off the belt, the plan is where it would be at the travel that the encoder measures: a
belt that slows down or stops takes the arm along, on the path that was proven. Before the tool works on the
belt and after that, wherever the belt carries what rides on it is proven, too; the plan may fall behind the
belt there, and returns to the clock of the controller once the item is off it. The rate of the plan's time
changes as quickly as the limits of the joints allow. A belt from which the plan strays while the tool works
on it is told early enough for a way off within what the proof allows (``belt_way_off``).

Only the deviation of the travel from that of the plan's speed is filtered, by three first-order lags whose
delay is made up for by the rate of the deviation, so that a steady belt is followed without an error, and
counts of the encoder do not shake the axis.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol, runtime_checkable

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.kinematics.linear_axis import linear_axis
from pickcli.motion.plan import Plan, times_at_work
from pickcli.simulation.online_time_scaling import OnlineTimeScaling
from pickcli.timing.line_tracking import MOST_PACE

LAG_RATE = 25.0  # 1/s of each lag: 1 mm off a belt that changes its speed at 0.2 m/s^2
CATCH_UP = 10.0  # 1/s at which the plan makes up for time that it is behind the belt, or ahead of it
COMING_CHANGE = 0.6  # 1/s of the pace while the whole arm moves, which is on its way at its own limits
LEAVE_AT = 0.9  # of the deviation that is proven: the arm leaves a belt that would come to more
BELT_SHARE = 0.6  # of the limits of the axis, with which it follows a belt that the plan cannot follow
BUILT_UP = 2.2  # times the way in which it comes to that speed: its acceleration has to be built up
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
        t_follows: s of the plan from which its time is that of the belt: where the arm last rests before the
            tool works on the belt, or from the start if it does not move until then.
        t_works: s of the plan from which the tool works on the belt.
        t_left: s of the plan at which the item is off the belt.
        follows_by_axis: Whether an axis along the belt follows it, not all joints.
        off: m by which the belt is ahead of the plan, negative if it is behind.
        comes_to: m by which it would be off until the axis has come to its speed on the way off.
        allowed: m of that from which on the arm leaves it.
        scaling: The time of the plan.
    """

    def __init__(self, plan: Plan, cell: Cell, encoder: BeltEncoder, time_step: float) -> None:
        assert plan.tracking is not None
        self._tracking = plan.tracking
        self.t_works, self.t_left = times_at_work(plan.segments)
        self._encoder, self._time_step = encoder, time_step
        limits = cell.robot.limits
        scaled = replace(limits, acceleration=cell.speed_scale * limits.acceleration)
        self.scaling = OnlineTimeScaling(plan.trajectory, scaled, time_step)
        times, speeds = plan.trajectory.times, np.abs(plan.trajectory.velocities).max(axis=1)
        t_rests = float(times[(times < self.t_works) & (speeds <= AT_REST)].max(initial=0.0))
        self.t_follows = t_rests if float(speeds[times <= t_rests].max(initial=0.0)) > AT_REST else 0.0
        speed = self._tracking.speed
        self._latency = encoder.encoder_latency(self._tracking.conveyor)
        self._last = 0.0  # m, last reading
        self._t = -self._latency  # s since the start, of the next reading
        self._start = self._reading() - speed * self._t  # where the belt was at the start
        self._lags, self._belt, self._travel = np.zeros(3), 0.0, 0.0
        self.off, self.comes_to, self.allowed = 0.0, 0.0, LEAVE_AT * self._tracking.deviation
        belt = cell.carriers[plan.tracking.conveyor]
        assert belt.conveyor is not None
        found = linear_axis(cell.robot, belt.T_world_carrier[:3, 0])
        self.follows_by_axis = found is not None
        self._gain: float | None = None  # m/s^2 by which an axis catches up with the belt on the way off
        if found is not None:
            self._gain = BELT_SHARE * float(scaled.acceleration[found[0]]) - belt.conveyor.max_acceleration

    @property
    def is_off(self) -> bool:
        """Whether the plan strays from the belt while the tool works on it."""
        return self.t_works < self.scaling.t < self.t_left and self.comes_to > self.allowed

    def next(self) -> float:
        """Return the time of the plan at the next set point.

        Returns:
            s of the plan.
        """
        scaling = self.scaling
        waits = scaling.t <= self.t_follows
        before, rate = self.measure()
        if scaling.t >= self.t_left:
            wanted = 1.0
        else:
            # The arm comes in its own time, and waits for the belt where it begins to follow that.
            told = min(max(rate + CATCH_UP * (before - scaling.t), 0.0), MOST_PACE)
            wanted = 1.0 if waits else told
        is_beside = waits or scaling.t >= self.t_left
        t = scaling.advance(wanted, COMING_CHANGE if is_beside else np.inf)
        if waits and t > self.t_follows and self._belt < t - WAITED:
            t = scaling.hold(max(self.t_follows, self._belt))
        self.off = self.off_at(t, scaling.rate)
        self.comes_to = abs(self.off) + self._growth(self._tracking.speed * (rate - scaling.rate))
        return t

    def _growth(self, faster: float) -> float:
        """Length (m) by which a belt that is some m/s faster gets farther off the plan on the way off."""
        if self._gain is None or faster * self.off <= 0.0:
            return 0.0  # without an axis the way off is the plan's own motion
        return BUILT_UP * faster**2 / (2.0 * self._gain) if self._gain > 0.0 else float("inf")

    def off_at(self, t: float, rate: float) -> float:
        """Compute by how much the belt is ahead of where a time of the plan puts it.

        Args:
            t: s of the plan at the next set point.
            rate: Of that time.

        Returns:
            m.
        """
        return self._travel - self._tracking.speed * (t - rate * (self._latency + self._time_step))

    def measure(self) -> tuple[float, float]:
        """Measure the belt, once for each set point.

        Returns:
            s of the plan at which its belt would have been where the belt was at the last set point, and the
            rate of that time now.
        """
        before = self._belt
        self._travel = self._reading() - self._start
        self._belt = self._belt_time(self._travel) + self._time_step
        return before, (self._belt - before) / self._time_step

    def stopping(self) -> float:
        """Return the time of the plan at the next set point of a stop, as quick as the limits allow.

        Returns:
            s of the plan.
        """
        return self.scaling.advance(0.0, self.scaling.bearable_change)

    @property
    def rate(self) -> float:
        """Rate of the plan's time at the last set point."""
        return self.scaling.rate

    def _reading(self) -> float:
        """Travel (m) by the encoder."""
        travel = self._encoder.belt_travel(self._tracking.conveyor)
        self._last = self._last if travel is None else travel
        return self._last

    def _belt_time(self, travel: float) -> float:
        """Time (s) of the plan at which its belt would be where the belt is now."""
        step, speed = self._time_step, self._tracking.speed
        before = travel - speed * self._t
        for k in range(3):
            self._lags[k] += step * LAG_RATE * (before - self._lags[k])
            before = self._lags[k]
        ahead = (3.0 + LAG_RATE * self._latency) * float(self._lags[1] - self._lags[2])
        now = self._t + self._latency
        self._t += step
        return now + (float(self._lags[2]) + ahead) / speed
