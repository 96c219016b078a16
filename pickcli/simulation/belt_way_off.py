"""The way off a running belt: back along the lines or on along them, with the belt, then to rest over it.

The motion has two clocks. The lines relative to the belt are followed by that of the controller, back to
where they begin or on to where they end; the axis along the belt follows the travel that the encoder
measures, whatever the belt does. At either end of the lines the arm is clear of all that the belt may
bring, and the axis comes to rest. The plan's proof holds for all of it: the lines relative to the belt are
those of the plan, and they are proven free of the hall wherever along its axis the arm is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.robot import Limits
from pickcli.geometry import Array
from pickcli.kinematics.linear_axis import linear_axis
from pickcli.motion.plan import Plan
from pickcli.motion.trajectory import Trajectory
from pickcli.simulation.belt_clock import BELT_SHARE, CATCH_UP, BeltClock
from pickcli.simulation.online_time_scaling import OnlineTimeScaling
from pickcli.timing.line_tracking import BACK, relative_to_belt

SAME_TIME = 1e-6  # s
LONGEST = 30.0  # s of the belt's time that a way off may last
BEFORE_END = 0.01  # m before the end of the axis where it is at rest at the latest
SLOWING = 0.15  # s that it needs to build up its acceleration, and to take it back


class BeltWayOff:
    """Follows one way off the belt, from where the plan is.

    Args:
        plan: The plan, with a conveyor.
        cell: Its cell.
        clock: The clock of the plan, which it no longer drives.
        time_step: s between two set points.
        is_back: Whether the lines are gone back instead of on.

    The tool works on the belt, and the item is not off it yet.

    Attributes:
        t: s of the plan at which the arm is relative to the belt.
        off: m by which the belt is ahead of the arm, negative if it is behind.
        is_clear: Whether the arm has come to the end of the lines: it is clear of what the belt may bring.
    """

    def __init__(self, plan: Plan, cell: Cell, clock: BeltClock, time_step: float, is_back: bool) -> None:
        assert plan.tracking is not None
        robot, T_world_belt = cell.robot, cell.carriers[plan.tracking.conveyor].T_world_carrier
        found = linear_axis(robot, T_world_belt[:3, 0])
        assert found is not None
        self._axis, self._speed = found[0], found[1] * plan.tracking.speed
        self._plan, self._clock, self._time_step, self._is_back = plan, clock, time_step, is_back
        limits = robot.limits
        self._limits = replace(limits, acceleration=cell.speed_scale * limits.acceleration)
        as_seen = relative_to_belt(plan.trajectory, self._axis, self._speed, clock.t_works)
        self._lines = as_seen.between(clock.t_works, clock.t_left, SAME_TIME)
        now, t_works = clock.scaling, clock.t_works
        self.t, self.off, self.is_clear = now.t, clock.off, now.t <= t_works
        self._on = OnlineTimeScaling(self._lines, self._beside_the_belt, time_step)
        self._on.begin(self.t - t_works, now.rate, now.change)
        self._back: OnlineTimeScaling | None = None
        self._u, self._belt = now.t, self._belt_scaling(BELT_SHARE)  # s of the belt at its beginning
        self._belt.begin(0.0, now.rate, now.change)
        self._slows = False

    @property
    def is_at_rest(self) -> bool:
        """Whether the arm is at rest."""
        return self.is_clear and self._slows and self._belt.rate == 0.0

    def turn_back(self) -> None:
        """Go back along the lines from now on."""
        self._is_back = True

    def next(self) -> Array:
        """Return the next set point.

        Returns:
            (n,) configuration.
        """
        before, rate = self._clock.measure()
        if not self.is_clear:
            self._follow_lines()  # also near the end of the axis: on the lines is no place to stay
        if self._slows:
            self._belt.advance(0.0)
            return self._point()
        self._belt.advance(max(0.0, rate + CATCH_UP * (before - self._u - self._belt.t)))
        self.off = self._clock.off_at(self._u + self._belt.t, self._belt.rate)
        q = self._point()
        if self.is_clear or self._is_near_end(float(q[self._axis])):
            self._slow_down()
        return q

    def _point(self) -> Array:
        """Return the configuration (n,) on the lines, carried along with the belt."""
        q = self._plan.trajectory.sample(self.t)[0].copy()
        q[self._axis] += self._speed * (self._u + self._belt.t - self.t)
        return np.asarray(q)

    def _follow_lines(self) -> None:
        """Go on along the lines, or brake and go back along them."""
        start, duration = self._clock.t_works, self._lines.duration
        if not self._is_back:
            self.t = start + self._on.advance(1.0, self._on.bearable_change)
            self.is_clear = self._on.t >= duration
        elif self._back is None:
            self.t = start + self._on.advance(0.0, self._on.bearable_change)
            if self._on.rate == 0.0:
                self._back = OnlineTimeScaling(_reversed(self._lines), self._beside_the_belt, self._time_step)
                self._back.begin(duration - self._on.t, 0.0)
        else:
            self.t = start + duration - self._back.advance(BACK, self._back.bearable_change)
            self.is_clear = self._back.t >= duration

    def _slow_down(self) -> None:
        """Let the axis come to rest from now on."""
        now, self._slows = self._belt, True
        self._u += now.t
        self._belt = self._belt_scaling(self._axis_share)
        self._belt.begin(0.0, now.rate, now.change)

    def _is_near_end(self, at: float) -> bool:
        """Whether the axis, at a position (m), has to come to rest before its end."""
        k, limits = self._axis, self._limits
        v = self._speed * self._belt.rate
        needs = abs(v) * (abs(v) / (self._axis_share * float(limits.acceleration[k])) + SLOWING) + BEFORE_END
        left = limits.upper[k] - at if v > 0.0 else at - limits.lower[k]
        return bool(left < needs)

    @property
    def _axis_share(self) -> float:
        """Share of its limits with which the axis may come to rest: the lines have the rest."""
        return 1.0 if self.is_clear else BELT_SHARE

    @property
    def _beside_the_belt(self) -> Limits:
        """What the axis has left for the lines while it follows the belt."""
        acceleration, jerk = self._limits.acceleration.copy(), self._limits.jerk.copy()
        acceleration[self._axis] *= 1.0 - BELT_SHARE
        jerk[self._axis] *= 1.0 - BELT_SHARE
        return replace(self._limits, acceleration=acceleration, jerk=jerk)

    def _belt_scaling(self, share: float) -> OnlineTimeScaling:
        """Return the time of the axis alone, at the speed of the plan, at a share of its limits."""
        limits, k = self._limits, slice(self._axis, self._axis + 1)
        alone = Limits(
            limits.lower[k], limits.upper[k], limits.velocity[k], share * limits.acceleration[k],
            share * limits.jerk[k],
        )  # fmt: skip
        t, v = np.array([0.0, LONGEST]), np.full((2, 1), self._speed)
        way = Trajectory(self._lines.joint_names[k], t, v * t[:, None], v, np.zeros((2, 1)))
        return OnlineTimeScaling(way, alone, self._time_step)


def _reversed(trajectory: Trajectory) -> Trajectory:
    """Return a trajectory backwards in time."""
    t = trajectory.times
    return Trajectory(
        trajectory.joint_names, t[-1] - t[::-1], trajectory.positions[::-1].copy(),
        -trajectory.velocities[::-1], trajectory.accelerations[::-1].copy(),
    )  # fmt: skip
