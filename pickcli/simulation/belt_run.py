"""Run of a plan that may follow a running conveyor by its encoder, and leaves that when it is stopped.

What supervises the plan supervises the way off the belt as well: contacts, joints that do not follow, and the
hold are judged at every set point of it.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np

from pickcli.cell.device import DeviceKind
from pickcli.errors import InputError
from pickcli.geometry import Array
from pickcli.kinematics.linear_axis import linear_axis
from pickcli.motion.segment import SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.simulation.belt_clock import BeltClock, BeltEncoder
from pickcli.simulation.belt_way_off import BeltWayOff
from pickcli.simulation.operator_stop import OperatorStop, never
from pickcli.simulation.plan_record import PlanRecord
from pickcli.simulation.plan_run import D, PathMotion, PlanRun
from pickcli.simulation.planned_way_off import PlannedWayOff
from pickcli.simulation.protective_stop import ProtectiveStop, StopCause

STANDING = 1e-6  # s of the plan in a step: slower, a belt stands
OWN_PACE = 1e-6  # difference of the rate of the plan's time from 1, which is none
OWN_CHANGE = 2e-5  # 1/s of that rate, which is none: what is dropped at once is a jerk of every joint
MOST_HELD = 60.0  # s for which a plan waits for a belt that has stopped
LONGEST_LAG = 500  # set points among which the measured configuration is searched: half a second
HARD = (StopCause.CONTACT, StopCause.FOLLOWING_ERROR)  # after which motors brake as hard as they can
MOST_BRAKING = 1.0  # s, upper bound of the time in which the heaviest joint stops from full speed


class BeltRun(PlanRun[D]):
    """Run of a plan, by the encoder of the conveyor that it follows if there is one.

    Attributes:
        is_clear: Whether the arm rests clear of all that a belt may bring, after a stop; None without one.
        stops_on_way_off: What was judged to be amiss on the way off the belt.
    """

    is_clear: bool | None = None
    stops_on_way_off: tuple[ProtectiveStop, ...] = ()
    _clock: BeltClock | None = None  # that tells the plan's time
    _is_beside_belt = False  # whether the motion keeps clear of all that a belt may bring
    _sent_lately: deque[tuple[Array, float]] | None = None  # on the way off, from where the robot is on

    def before_own_pace(self) -> float:
        """Follow the belt, as long as it tells the plan's time.

        Returns:
            s of the plan from which it goes at its own pace.

        Raises:
            InputError: The belt has to be measured and is not.
        """
        self._clock = clock = self._belt_clock()
        if clock is not None:
            self._follow_belt(clock)
            return self.t_motion
        if self.plan.tracking is not None and self.operator is not never:
            why = "the operator stops no motion over a belt that no encoder measures"
            raise InputError(f"{self.plan.query}: {why}; measure its travel, or stop the belt as well")
        return 0.0

    def record(self) -> PlanRecord:
        """Record what has been carried out and measured, on the way off the belt, too.

        Returns:
            The record so far.
        """
        return replace(super().record(), is_clear=self.is_clear, stops_on_way_off=self.stops_on_way_off)

    @property
    def progress(self) -> float:
        """Time (s) of the plan where the robot is; on the way off a belt, relative to that."""
        return self.tracker.progress if self._sent_lately is None else self._sent_lately[0][1]

    def brake(self, why: ProtectiveStop) -> None:
        """Stop on the path, or on the way off the belt.

        Args:
            why: The reason.
        """
        if self._clock is None:
            super().brake(why)
        elif why.cause in HARD:
            self._brake_hard()
        else:
            self._stop_at_belt(self._clock, why)

    def halt(self, motion: PathMotion) -> None:
        """Stop for good on the path.

        Args:
            motion: The motion that is being sent.
        """
        super().halt(motion)
        if self._is_beside_belt:
            self.is_clear = True

    def brake_beside(self, motion: PathMotion, at: float) -> None:
        """Stop as hard as possible, even if that leaves the path: the set points follow the encoders.

        Args:
            motion: The motion that was sent.
            at: s of it where the robot is.
        """
        driver = self.driver
        self.n_judged = len(self.trace.sent)
        self.path_time = motion.path_time(at)
        self.t_standing, t_end = None, driver.t + MOST_BRAKING
        while self.t_standing is None and driver.t < t_end:
            self.send_beside(driver.q, self.path_time)
        self.is_clear = True if self._is_beside_belt else None if self._clock is None else False

    def send_beside(self, q: Array, t_plan: float) -> None:
        """Send a set point of a stop beside the path.

        Args:
            q: (n,) configuration.
            t_plan: s of the plan.
        """
        self.set_point(q, t_plan)

    def release(self, cause: StopCause) -> None:
        """Switch pump and valves off if a cause says that there is no hold, or none to come.

        Args:
            cause: The cause.
        """
        if cause in (StopCause.SEAL_LOST, StopCause.NOT_SEALED, StopCause.EARLY_CONTACT):
            self._switch_off()

    def _belt_clock(self) -> BeltClock | None:
        """Return what tells the plan's time by a running conveyor; None without one that is measured.

        Raises InputError if the plan needs one.
        """
        tracking, encoder = self.plan.tracking, self.driver
        if tracking is None:
            return None
        if isinstance(encoder, BeltEncoder) and encoder.belt_travel(tracking.conveyor) is not None:
            return BeltClock(self.plan, encoder.cell, encoder, encoder.time_step)
        off = tracking.speed_error * self.plan.trajectory.duration
        if off > tracking.deviation:
            why = f"without an encoder the belt may be {1e3 * off:.1f} mm off, {1e3 * tracking.deviation:.1f}"
            raise InputError(
                f"{self.plan.query}: {why} are proven; measure its travel, or state its speed better"
            )
        return None

    def _follow_belt(self, clock: BeltClock) -> None:
        """Send the set points of a plan whose time is told by the belt, until that goes its own way.

        That is where the item is off the belt, and the plan has its own pace again; or a stop is requested.
        """
        t_plan, trajectory, t_held = 0.0, self.plan.trajectory, 0.0
        while t_plan < trajectory.duration:
            self._operator_asks(t_plan)
            if self.stop is not None:
                return
            t_next = clock.next()
            t_held = 0.0 if abs(t_next - t_plan) > STANDING else t_held + self.driver.time_step
            self.t_motion = t_plan = t_next
            self.set_point(trajectory.sample(t_plan)[0], t_plan)
            if self.stop is None and (why := self._strayed(clock, t_held)) is not None:
                self.stop, self.stopped_in = why, self.segment_at(t_plan)
            is_steady = abs(clock.rate - 1.0) < OWN_PACE and abs(clock.scaling.change) < OWN_CHANGE
            if t_plan > clock.t_left and is_steady:
                self._clock, self._is_beside_belt = None, True
                return

    def _operator_asks(self, t_plan: float) -> None:
        """Note whether the operator stops a motion at a belt; until its item is met, that ends the motion.

        From then on the item is taken off the belt before the motion rests.
        """
        stops, t = self.operator_stops, self.driver.t - self.t_start
        is_asked, is_noted = self.operator(self.driver.t), bool(stops) and stops[-1].end is None
        if is_asked and not is_noted:
            stops.append(OperatorStop(t, None))
        if is_noted and not is_asked:
            stops[-1] = replace(stops[-1], end=t)
        if is_asked and t_plan < self._t_met:
            assert self.plan.tracking is not None
            conveyor = self.plan.tracking.conveyor
            self.stop = ProtectiveStop(StopCause.OPERATOR, conveyor, 0.0, 0.0, "", self.driver.t)
            self.stopped_in = self.segment_at(t_plan)

    @property
    def _t_met(self) -> float:
        """Time (s) of the plan at which the tool may meet the item that it takes."""
        return next(s.t_start for s in self.plan.segments if s.kind is SegmentKind.CONTACT)

    def _stop_at_belt(self, clock: BeltClock, why: ProtectiveStop) -> None:
        """Stop on the path where the arm is clear of what the belt may bring, else leave the belt."""
        if 0.0 < clock.t_follows >= clock.scaling.t:
            self._is_beside_belt = True
            self.halt(PathMotion(_until(self.plan.trajectory, clock.t_follows), lambda t: t))
            return
        # While an axis comes up to its speed, the arm is clear of the belt; then it can leave it at any pace.
        if clock.follows_by_axis and not self._slow_down(clock, clock.t_works):
            return
        is_clear = clock.follows_by_axis and clock.scaling.t < clock.t_works
        if clock.scaling.t < clock.t_left and not is_clear:
            self._leave_belt(clock, clock.scaling.t < self._t_met or why.cause is StopCause.EARLY_CONTACT)
            self.path_time = self.trace.plan_times[-1]
        elif self._slow_down(clock, np.inf):
            self.path_time, self.is_clear = clock.scaling.t, True

    def _slow_down(self, clock: BeltClock, until: float) -> bool:
        """Slow down on the path, to rest or until a time (s) of the plan; False if motors had to brake."""
        while clock.rate > 0.0 and clock.scaling.t < until:
            t_plan = clock.stopping()
            q = self.plan.trajectory.sample(t_plan)[0]
            self.set_point(q, t_plan)
            hard = self.reason_to_stop(q, t_plan)
            if hard is not None and hard.cause in HARD:
                self.stops_on_way_off += (hard,)
                self._brake_hard()
                return False
        return True

    def _brake_hard(self) -> None:
        """Stop as hard as possible, from where the robot is on the path."""
        at = min(self.progress, self.trace.plan_times[-1])
        self.brake_beside(PathMotion(self.plan.trajectory, lambda t: t), at)

    def _leave_belt(self, clock: BeltClock, is_back: bool) -> None:
        """Take the way off the belt, back along the lines to the item or on along those with it."""
        if is_back:
            self._switch_off()
        trace = self.trace
        off = self._way_off(clock, is_back)
        sent = zip(trace.sent[-LONGEST_LAG:], trace.plan_times[-LONGEST_LAG:], strict=True)
        self._sent_lately = deque(sent, LONGEST_LAG)
        while not off.is_at_rest:
            q, t_plan = off.next(), off.t
            self._sent_lately.append((q, t_plan))
            self.set_point(q, t_plan)
            self._find_progress(self._sent_lately)
            why = self.reason_to_stop(q, t_plan)
            if why is not None and not self._goes_on(off, why):
                self.brake_beside(*self._sent_motion(len(self._sent_lately)))
                break
        else:
            self.is_clear = off.is_clear

    def _way_off(self, clock: BeltClock, is_back: bool) -> BeltWayOff | PlannedWayOff:
        """Return the way off for an arm that follows the belt by its axis, or by all of its joints."""
        assert self.plan.tracking is not None
        driver, cell = self.driver, self.driver.cell
        along = cell.carriers[self.plan.tracking.conveyor].T_world_carrier[:3, 0]
        if linear_axis(cell.robot, along) is None:
            return PlannedWayOff(self.plan, clock, driver.time_step)
        return BeltWayOff(self.plan, cell, clock, driver.time_step, is_back)

    def _find_progress(self, sent: deque[tuple[Array, float]]) -> None:
        """Forget the set points (n,), with s of the plan, before the one at which the robot is."""
        away = np.linalg.norm(np.array([q for q, _ in sent]) - self.driver.q, axis=1)
        # Of equal ones the last: at rest the robot has come to all of them.
        for _ in range(len(away) - 1 - int(np.argmin(away[::-1]))):
            sent.popleft()

    def _goes_on(self, off: BeltWayOff | PlannedWayOff, why: ProtectiveStop) -> bool:
        """React to what was judged on the way off; return whether that is followed any farther."""
        assert self.stop is not None
        known = {each.cause for each in (self.stop, *self.stops_on_way_off)}
        is_hard = why.cause in HARD
        is_known = why.cause in known or (
            why.cause.is_measured_empty and any(each.is_measured_empty for each in known)
        )
        if is_known and not is_hard:
            return True
        self.stops_on_way_off += (why,)
        self.release(why.cause)
        if why.cause is StopCause.EARLY_CONTACT:
            off.turn_back()
        return not is_hard

    def _sent_motion(self, n_behind: int) -> tuple[PathMotion, float]:
        """Return the set points of the last half second as a motion, and s of it where the robot is.

        n_behind: number of set points from there to the last one
        """
        step, trace = self.driver.time_step, self.trace
        q, plan_times = np.array(trace.sent[-LONGEST_LAG:]), np.array(trace.plan_times[-LONGEST_LAG:])
        times, v = step * np.arange(len(q), dtype=float), np.gradient(q, step, axis=0)
        a: Array = np.gradient(v, step, axis=0)
        motion = Trajectory(self.plan.trajectory.joint_names, times, q, v, a)
        at = float(times[max(0, len(q) - n_behind)])
        return PathMotion(motion, lambda t: np.interp(t, times, plan_times)), at

    def _switch_off(self) -> None:
        """Switch pump and valves off."""
        driver = self.driver
        for device in driver.cell.devices.values():
            if device.kind in (DeviceKind.PUMP, DeviceKind.VALVE):
                driver.act(device.name, "off")

    def _strayed(self, clock: BeltClock, t_held: float) -> ProtectiveStop | None:
        """Stop for a belt that stands for too long (t_held, s), or is not where the plan's proof has it."""
        assert self.plan.tracking is not None
        conveyor, now = self.plan.tracking.conveyor, self.driver.t
        if t_held >= MOST_HELD:
            return ProtectiveStop(StopCause.BELT, conveyor, t_held, MOST_HELD, "s at rest", now)
        if not clock.is_off:
            return None
        where = f"{conveyor}, {'behind' if clock.off < 0.0 else 'ahead of'} the plan,"
        return ProtectiveStop(StopCause.BELT, where, 1e3 * clock.comes_to, 1e3 * clock.allowed, "mm", now)


def _until(trajectory: Trajectory, t_end: float) -> Trajectory:
    """Return the part of a trajectory up to one of its points (s), where it rests."""
    kept = trajectory.times <= t_end
    rows = (trajectory.positions, trajectory.velocities, trajectory.accelerations)
    return Trajectory(trajectory.joint_names, trajectory.times[kept], *(row[kept] for row in rows))
