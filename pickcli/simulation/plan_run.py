"""Carries out a plan by any driver: streams set points, fires events by measured progress, and stops.

A stop that the operator requests is followed by the rest of the plan, any other one ends it.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Generic, TypeVar

import numpy as np

from pickcli.cell.device import DeviceKind
from pickcli.cell.robot import Limits
from pickcli.errors import InputError
from pickcli.geometry import Array
from pickcli.io_events.tracker import EventTracker
from pickcli.kinematics.arm import Arm
from pickcli.motion.event import Event
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.progress import Progress, ProgressObserver
from pickcli.simulation.belt_clock import BeltClock, BeltEncoder
from pickcli.simulation.belt_way_off import BeltWayOff
from pickcli.simulation.driver import Driver
from pickcli.simulation.following import JointFollowing
from pickcli.simulation.operator_stop import OperatorSignal, OperatorStop, never
from pickcli.simulation.plan_record import FiredEvent, PlanRecord
from pickcli.simulation.protective_stop import ProtectiveStop, StopCause
from pickcli.simulation.start_check import at_the_robot, check_start
from pickcli.simulation.stream import Pace, Stream, full_speed, stream, violations
from pickcli.simulation.trigger import TriggerDistance

END_TIME = 0.1  # s after the last set point, in which the servo arrives and the last events fire
STOPPED_SPEED = 0.02  # rad/s or m/s; a stopping robot is at rest if all joints are slower
SEAL_TIME = 1.5  # s beyond the plan's wait on an item; a line that leaked is evacuated to 0.95 in this time
REST_TOLERANCE = 1e-6  # rad/s or m/s of every joint
STANDING = 1e-6  # s of the plan in a step: slower, a belt stands
OWN_PACE = 1e-6  # difference of the rate of the plan's time from 1, which is none
MOST_HELD = 60.0  # s for which a plan waits for a belt that has stopped
TRACE_STEPS = 10  # steps between samples of the tool's lag
PROGRESS_STEPS = 100  # steps between reports of progress

D = TypeVar("D", bound=Driver)


def drive(
    plan: Plan,
    driver: Driver,
    *,
    pace: Pace = full_speed,
    operator: OperatorSignal = never,
    on_progress: ProgressObserver | None = None,
) -> PlanRecord:
    """Carry out a plan, to its end or to a stop on its path.

    On the item the robot waits until a sensor says that it is held, at most ``SEAL_TIME`` longer than
    planned. It stops if a joint does not follow, or if an event reads that nothing is held.

    Args:
        plan: The plan.
        driver: The driver that carries it out.
        pace: Speed of the plan's time.
        operator: Whether the operator stops the robot, asked at every set point. It stays at rest on its path
            as long as that is so, and then goes on; over a running belt it leaves that first, and ends if the
            item was not met yet.
        on_progress: Called every 100 set points with the seconds of the plan and its segment.

    Returns:
        The record of the execution.

    Raises:
        StaleError: The plan is for another cell.
        StartError: The robot is not where the plan begins.
        InputError: The tool is in another state than at the start of the plan.
    """
    plan = at_the_robot(plan, driver)
    check_start(plan, driver)
    run = PlanRun(plan, driver, pace, on_progress)
    run.operator = operator
    run.play()
    return run.record()


@dataclass
class _Trace:
    """Data recorded during a run."""

    fired: list[FiredEvent] = field(default_factory=list)
    sent: list[Array] = field(default_factory=list)  # set points
    plan_times: list[float] = field(default_factory=list)  # one per set point
    commanded: list[Array] = field(default_factory=list)  # commanded configuration, every TRACE_STEPS
    measured: list[Array] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class _Motion:
    """A motion along the plan's path.

    path_times: the plan's times (N,) s at times (N,) s of the trajectory
    """

    trajectory: Trajectory
    path_times: Callable[[Array], Array]

    @property
    def end(self) -> float:
        """Time of the plan at the end, s."""
        return float(self.path_times(np.array([self.trajectory.duration]))[0])

    def stopped(self, at: float, limits: Limits) -> _Motion:
        """Return this motion with the fastest stop that is requested at a time (s) of it."""
        from pickcli.timing.stopping_trajectory import stop

        halted = stop(self.trajectory, at, limits)
        return _Motion(halted.trajectory, lambda t: self.path_times(halted.path_times(t)))


class PlanRun(Generic[D]):
    """Run of a plan. Subclasses for robots with more measurements override what is judged.

    Args:
        plan: The plan, which begins where the robot stands.
        driver: The driver that carries it out.
        pace: Speed of the plan's time.
        on_progress: Called every 100 set points.
        on_step: Called after every step.
    """

    def __init__(
        self,
        plan: Plan,
        driver: D,
        pace: Pace = full_speed,
        on_progress: ProgressObserver | None = None,
        on_step: Callable[[D], None] | None = None,
    ) -> None:
        self.plan, self.driver, self.pace = plan, driver, pace
        self.on_progress, self.on_step = on_progress, on_step
        self.arm = Arm(driver.cell.robot)
        self.tracker = EventTracker(plan.trajectory, plan.segments, plan.events)
        self.distance = TriggerDistance(plan, self.arm)
        self.following = JointFollowing(driver.q, driver.time_step)
        self.trace = _Trace()
        self.t_start = driver.t
        self.n_steps = 0
        self.stop: ProtectiveStop | None = None
        self.stopped_in: Segment | None = None
        self.path_time: float | None = None
        self.n_judged: int | None = None  # number of set points under the planned limits; all if None
        self.t_standing: float | None = None
        self._q_before = driver.q
        self._segment_ends = [segment.t_end for segment in plan.segments]
        self.t_sealed = _end_of_sealing(plan)
        self.operator: OperatorSignal = never
        self.operator_stops: list[OperatorStop] = []
        self.is_clear: bool | None = None  # of all that a belt may bring, at rest after a stop
        self._motion = _Motion(plan.trajectory, lambda t: t)  # that is being sent
        self._clock: BeltClock | None = None  # that tells its time
        self._is_beside_belt = False  # whether it keeps clear of all that a belt may bring
        self._t_motion = 0.0  # s of it at the last set point

    def play(self) -> None:
        """Carry out the plan, and wait until the robot has arrived."""
        self._clock = clock = self._belt_clock()
        rest: _Motion | None = self._motion
        begin = 0.0
        if clock is not None:
            self._follow_belt(clock)
            begin = self._t_motion
        elif self.plan.tracking is not None and self.operator is not never:
            why = "the operator stops no motion over a belt that no encoder measures"
            raise InputError(f"{self.plan.query}: {why}; measure its travel, or stop the belt as well")
        while rest is not None and self.stop is None:
            rest, begin = self._after_operator_stop() if self._send(rest, begin) else None, 0.0
        if self.stop is not None:
            self.brake(self.stop)
        for _ in range(round(self.end_time / self.driver.time_step)):
            self.step()

    def record(self) -> PlanRecord:
        """Record what has been carried out and measured.

        Returns:
            The record so far.
        """
        cell, trace = self.driver.cell, self.trace
        judged = slice(self.n_judged)
        commands = Stream(np.array(trace.plan_times[judged]), np.array(trace.sent[judged]))
        fired = {id(f.event) for f in trace.fired}
        return PlanRecord(
            t_start=self.t_start,
            t_end=self.driver.t,
            stop=self.stop,
            stopped_in=self.stopped_in.kind if self.stopped_in else None,
            events=tuple(trace.fired),
            missed=() if self.stop else tuple(e for e in self.plan.events if id(e) not in fired),
            limit_violations=violations(
                commands,
                self.plan.trajectory.joint_names,
                cell.robot.limits,
                self.driver.time_step,
                cell.speed_scale,
            ),
            max_lag=self._max_lag(),
            path_time=self.path_time,
            stopping_time=self._stopping_time(),
            operator_stops=tuple(self.operator_stops),
            is_clear=self.is_clear,
        )

    # What is judged ----------------------------------------------------------------------------------

    @property
    def end_time(self) -> float:
        """Time at rest after the plan or a stop until the robot counts as arrived, s."""
        return END_TIME

    def has_hold(self) -> bool:
        """Whether the item may be lifted: all sensors of the cell say that it is held.

        Returns:
            True also without sensors.
        """
        sensors = (d for d in self.driver.cell.devices.values() if d.kind is DeviceKind.SENSOR)
        return all(self.driver.act(sensor.name, sensor.actions[0]) for sensor in sensors)

    def reason_to_stop(self, command: Array, t_plan: float) -> ProtectiveStop | None:
        """Decide after a step whether to stop the motion.

        Args:
            command: (n,) set point.
            t_plan: s of the plan.

        Returns:
            The required stop, or None.
        """
        self.following.remember(command)
        if (off := self.following.worst(self.driver.q)) is not None:
            joint, error, allowed = off
            robot, cause = self.driver.cell.robot, StopCause.FOLLOWING_ERROR
            unit = robot.units[joint]
            return ProtectiveStop(cause, robot.joint_names[joint], error, allowed, unit, self.driver.t)
        return self.sensed_nothing()

    def sensed_nothing(self) -> ProtectiveStop | None:
        """Decide whether to stop because the last event read that nothing is held.

        Returns:
            The required stop, or None.
        """
        last = self.trace.fired[-1] if self.trace.fired else None
        if last is None or last.reading is not False:
            return None
        return ProtectiveStop(StopCause.SENSOR, last.event.device, 0.0, 1.0, "", self.driver.t)

    def before_set_point(self, t_plan: float) -> None:
        """Prepare for a set point; called before it is sent.

        Args:
            t_plan: s of the plan.
        """

    def after_step(self) -> None:
        """Take measurements after every step, before they are judged."""

    def brake(self, why: ProtectiveStop) -> None:
        """Stop on the planned path.

        Args:
            why: The reason.
        """
        if self._clock is not None:
            self._stop_at_belt(self._clock, why)
            return
        self._halt(self._motion)

    # How it runs -------------------------------------------------------------------------------------

    def _send(self, motion: _Motion, begin: float = 0.0, is_held: bool = False) -> bool:
        """Send the set points of a motion from a time (s) on; return whether the operator interrupts it.

        is_held: whether it brings the robot to rest for the operator already
        """
        is_braking, trace, driver = self.stop is not None, self.trace, self.driver
        t = len(trace.sent) * driver.time_step
        commands = stream(motion.trajectory, driver.time_step, self.pace, begin, t)
        self._motion, plan_times = motion, motion.path_times(commands.plan_times).tolist()
        times = zip(commands.plan_times.tolist(), plan_times, strict=True)
        for q, (t_motion, t_plan) in zip(commands.points, times, strict=True):
            if trace.sent and not (is_braking or is_held) and self.operator(driver.t):
                return True
            if self._lifts_off(t_plan):
                self._wait_for_hold()
            if self.stop is None or is_braking:
                self._t_motion = t_motion
                self._set_point(q, t_plan)
            if self.stop is not None and not is_braking:
                break
        return False

    def _halt(self, motion: _Motion) -> None:
        """Stop for good on the path of a motion, which is being sent."""
        halted = motion.stopped(self._t_motion, self.driver.cell.robot.limits)
        self.path_time = halted.end
        self._send(halted, self._t_motion)
        if self._is_beside_belt:
            self.is_clear = True

    def _after_operator_stop(self) -> _Motion | None:
        """Stop on the path until the operator releases the robot; return the rest of the motion."""
        from pickcli.timing.stopping_trajectory import resume

        trajectory, limits = self.plan.trajectory, self.driver.cell.robot.limits
        is_noted = bool(self.operator_stops) and self.operator_stops[-1].end is None
        begin = self.operator_stops.pop().begin if is_noted else self.driver.t - self.t_start
        if self.trace.plan_times[-1] >= trajectory.duration:
            return None
        halted = self._motion.stopped(self._t_motion, limits)
        self._send(halted, self._t_motion, is_held=True)
        while self.stop is None and self.operator(self.driver.t):
            self._set_point(self.trace.sent[-1], self.trace.plan_times[-1])
        end = None if self.stop is not None else self.driver.t - self.t_start
        self.operator_stops.append(OperatorStop(begin, end))
        if self.stop is not None or halted.end >= trajectory.duration:
            return None
        resumed = resume(trajectory, halted.end, limits)
        return _Motion(resumed.trajectory, resumed.path_times)

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
            self._t_motion = t_plan = t_next
            self._set_point(trajectory.sample(t_plan)[0], t_plan)
            if self.stop is None and (why := self._strayed(clock, t_held)) is not None:
                self.stop, self.stopped_in = why, self.segment_at(t_plan)
            if t_plan > clock.t_left and abs(clock.rate - 1.0) < OWN_PACE:
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
        """S of the plan at which the tool may meet the item that it takes."""
        return next(s.t_start for s in self.plan.segments if s.kind is SegmentKind.CONTACT)

    def _stop_at_belt(self, clock: BeltClock, why: ProtectiveStop) -> None:
        """Stop on the path where the arm is clear of what the belt may bring, else leave the belt."""
        t_plan, trajectory = clock.scaling.t, self.plan.trajectory
        if t_plan <= clock.t_follows:
            self._is_beside_belt = True
            self._halt(_Motion(_until(trajectory, clock.t_follows), lambda t: t))
        elif t_plan < clock.t_left:
            self._leave_belt(clock, t_plan < self._t_met or why.cause is StopCause.EARLY_CONTACT)
            self.path_time = self.trace.plan_times[-1]
        else:
            while clock.rate > 0.0:
                t_plan = clock.stopping()
                self._set_point(trajectory.sample(t_plan)[0], t_plan)
            self.path_time, self.is_clear = t_plan, True

    def _leave_belt(self, clock: BeltClock, is_back: bool) -> None:
        """Take the way off the belt, back along the lines to the item or on along those with it."""
        driver = self.driver
        for device in driver.cell.devices.values() if is_back else ():
            if device.kind in (DeviceKind.PUMP, DeviceKind.VALVE):
                driver.act(device.name, "off")
        off = BeltWayOff(self.plan, driver.cell, clock, driver.time_step, is_back)
        while not off.is_at_rest:
            self._set_point(off.next(), off.t)
        self.is_clear = off.is_clear

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

    def segment_at(self, t_plan: float) -> Segment:
        """Return the segment at a time of the plan.

        Args:
            t_plan: s of the plan.

        Returns:
            The segment; the last one after the end.
        """
        return self.plan.segments[min(bisect_left(self._segment_ends, t_plan), len(self._segment_ends) - 1)]

    def step(self) -> None:
        """Wait for a period, fire due events, and record measurements."""
        driver, trace = self.driver, self.trace
        driver.step()
        if self.stop is not None and self.t_standing is None:
            speed = np.abs(driver.q - self._q_before).max() / driver.time_step
            self.t_standing = driver.t if speed < STOPPED_SPEED else None
        self._q_before = driver.q
        if self.stop is None:
            for event in self.tracker.update(driver.q, driver.time_step):
                self._fire(event)
        self.after_step()
        self.n_steps += 1
        if self.n_steps % TRACE_STEPS == 0:
            trace.commanded.append(trace.sent[-1])
            trace.measured.append(driver.q)
        if self.n_steps % PROGRESS_STEPS == 0 and self.on_progress is not None:
            t_plan = trace.plan_times[-1]
            kind = str(self.segment_at(t_plan).kind)
            self.on_progress(Progress(t_plan, self.plan.trajectory.duration, kind))
        if self.on_step is not None:
            self.on_step(driver)

    def _set_point(self, q: Array, t_plan: float) -> None:
        self.trace.sent.append(q)
        self.trace.plan_times.append(t_plan)
        self.before_set_point(t_plan)
        self.driver.command(q)
        self.step()
        if self.stop is None and (why := self.reason_to_stop(q, t_plan)):
            self.stop, self.stopped_in = why, self.segment_at(t_plan)

    def _lifts_off(self, t_plan: float) -> bool:
        """Whether the next set point is the first after the rest in which the tool takes hold."""
        if self.stop is not None or self.t_sealed is None or not self.trace.sent:
            return False
        return self.trace.plan_times[-1] <= self.t_sealed < t_plan

    def _wait_for_hold(self) -> None:
        """Wait on the item until the tool has taken hold, at most ``SEAL_TIME``."""
        driver, q, t_plan = self.driver, self.trace.sent[-1], self.trace.plan_times[-1]
        t_end = driver.t + SEAL_TIME
        while driver.t < t_end and not self.has_hold():
            self._set_point(q, t_plan)
            if self.stop is not None:
                return

    def _fire(self, event: Event) -> None:
        reading = self.driver.act(event.device, event.action)
        distance = self.distance(event, self.driver.q, self.trace.plan_times[-1])
        self.trace.fired.append(FiredEvent(event, self.driver.t, distance, reading))

    def _stopping_time(self) -> float | None:
        if self.stop is None:
            return None
        return (self.driver.t if self.t_standing is None else self.t_standing) - self.stop.t

    def _max_lag(self) -> float:
        if not self.trace.commanded:
            return 0.0
        state = self.driver.cell.robot.tool.default_state
        commanded = self.arm.tips(np.array(self.trace.commanded), state)
        measured = self.arm.tips(np.array(self.trace.measured), state)
        return float(np.linalg.norm((commanded - measured)[:, :3, 3], axis=1).max())


def _until(trajectory: Trajectory, t_end: float) -> Trajectory:
    """Return the part of a trajectory up to one of its points (s), where it rests."""
    kept = trajectory.times <= t_end
    rows = (trajectory.positions, trajectory.velocities, trajectory.accelerations)
    return Trajectory(trajectory.joint_names, trajectory.times[kept], *(row[kept] for row in rows))


def _end_of_sealing(plan: Plan) -> float | None:
    """End time (s) of a plan's rest on the item to be picked; None if it does not rest there."""
    ends = [s.t_end for s in plan.segments if s.kind is SegmentKind.CONTACT and plan.grasp is not None]
    is_at_rest = bool(ends) and float(np.abs(plan.trajectory.sample(ends[0], 1)).max()) < REST_TOLERANCE
    return ends[0] if is_at_rest else None
