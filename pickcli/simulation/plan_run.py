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
from pickcli.geometry import Array
from pickcli.io_events.tracker import EventTracker
from pickcli.kinematics.arm import Arm
from pickcli.motion.event import Event
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.progress import Progress, ProgressObserver
from pickcli.simulation.driver import Driver
from pickcli.simulation.following import JointFollowing
from pickcli.simulation.operator_stop import OperatorSignal, OperatorStop, never
from pickcli.simulation.plan_record import FiredEvent, PlanRecord
from pickcli.simulation.protective_stop import ProtectiveStop, StopCause
from pickcli.simulation.stream import Pace, Stream, full_speed, stream, violations
from pickcli.simulation.trigger import TriggerDistance
from pickcli.timing.limit_check import peaks

END_TIME = 0.1  # s after the last set point, in which the servo arrives and the last events fire
STOPPED_SPEED = 0.02  # rad/s or m/s; a stopping robot is at rest if all joints are slower
SEAL_TIME = 1.5  # s beyond the plan's wait on an item; a line that leaked is evacuated to 0.95 in this time
REST_TOLERANCE = 1e-6  # rad/s or m/s of every joint
TRACE_STEPS = 10  # steps between samples of the tool's lag
PROGRESS_STEPS = 100  # steps between reports of progress
HARDER = 1.2  # times the accelerations of its plan that a stop with an item may use: plans load tools to 0.8
LEAST_STOP = 0.1  # share of the limits that a stop may use with an item, even where its plan uses less

D = TypeVar("D", bound=Driver)


@dataclass
class _Trace:
    """Data recorded during a run."""

    fired: list[FiredEvent] = field(default_factory=list)
    sent: list[Array] = field(default_factory=list)  # set points
    plan_times: list[float] = field(default_factory=list)  # one per set point
    commanded: list[Array] = field(default_factory=list)  # commanded configuration, every TRACE_STEPS
    measured: list[Array] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class PathMotion:
    """A motion along the plan's path.

    Attributes:
        trajectory: The motion.
        path_times: Returns the plan's times (N,) s at times (N,) s of the trajectory.
    """

    trajectory: Trajectory
    path_times: Callable[[Array], Array]

    @property
    def end(self) -> float:
        """Time of the plan at the end, s."""
        return self.path_time(self.trajectory.duration)

    def path_time(self, t: float) -> float:
        """Return the time of the plan at one of the motion.

        Args:
            t: s of the motion.

        Returns:
            s of the plan.
        """
        return float(self.path_times(np.array([t]))[0])

    def stopped(self, at: float, limits: Limits) -> PathMotion:
        """Return this motion with the fastest stop.

        Args:
            at: s of the motion at which it is requested.
            limits: Limits of the joints.

        Returns:
            The motion, which ends at rest.
        """
        from pickcli.timing.stopping_trajectory import stop

        halted = stop(self.trajectory, at, limits)
        return PathMotion(halted.trajectory, lambda t: self.path_times(halted.path_times(t)))


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
        self.motion = PathMotion(plan.trajectory, lambda t: t)  # that is being sent
        self.t_motion = 0.0  # s of it at the last set point

    def play(self) -> None:
        """Carry out the plan, and wait until the robot has arrived."""
        rest: PathMotion | None = self.motion
        begin = self.before_own_pace()
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
        )

    def before_own_pace(self) -> float:
        """Carry out what does not go at the plan's own pace; called before all else.

        Returns:
            s of the plan from which it does.
        """
        return 0.0

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

    @property
    def progress(self) -> float:
        """Time (s) of the plan where the robot is by its measured joints."""
        return self.tracker.progress

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
        self.halt(self.motion)

    # How it runs -------------------------------------------------------------------------------------

    def _send(self, motion: PathMotion, begin: float = 0.0, is_held: bool = False) -> bool:
        """Send the set points of a motion from a time (s) on; return whether the operator interrupts it.

        is_held: whether it brings the robot to rest for the operator already
        """
        is_braking, trace, driver = self.stop is not None, self.trace, self.driver
        t = len(trace.sent) * driver.time_step
        commands = stream(motion.trajectory, driver.time_step, self.pace, begin, t)
        self.motion, plan_times = motion, motion.path_times(commands.plan_times).tolist()
        times = zip(commands.plan_times.tolist(), plan_times, strict=True)
        for q, (t_motion, t_plan) in zip(commands.points, times, strict=True):
            if trace.sent and not (is_braking or is_held) and self.operator(driver.t):
                return True
            if self._lifts_off(t_plan):
                self._wait_for_hold()
            if self.stop is None or is_braking:
                self.t_motion = t_motion
                self.set_point(q, t_plan)
            if self.stop is not None and not is_braking:
                break
        return False

    def halt(self, motion: PathMotion) -> None:
        """Stop for good on the path.

        Args:
            motion: The motion that is being sent.
        """
        halted = motion.stopped(self.t_motion, self.driver.cell.robot.limits)
        self.path_time = halted.end
        self._send(halted, self.t_motion)

    def _after_operator_stop(self) -> PathMotion | None:
        """Stop on the path until the operator releases the robot; return the rest of the motion."""
        from pickcli.timing.stopping_trajectory import resume

        trajectory, limits = self.plan.trajectory, self._limits_of_stops
        is_noted = bool(self.operator_stops) and self.operator_stops[-1].end is None
        begin = self.operator_stops.pop().begin if is_noted else self.driver.t - self.t_start
        if self.trace.plan_times[-1] >= trajectory.duration:
            return None
        halted = self.motion.stopped(self.t_motion, limits)
        self._send(halted, self.t_motion, is_held=True)
        while self.stop is None and self.operator(self.driver.t):
            self.set_point(self.trace.sent[-1], self.trace.plan_times[-1])
        end = None if self.stop is not None else self.driver.t - self.t_start
        self.operator_stops.append(OperatorStop(begin, end))
        if self.stop is not None or halted.end >= trajectory.duration:
            return None
        resumed = resume(trajectory, halted.end, limits)
        return PathMotion(resumed.trajectory, resumed.path_times)

    @property
    def _limits_of_stops(self) -> Limits:
        """Limits of the operator's stop: with an item little more than the plan itself uses to carry it.

        For that the load on the tool was judged; at the limits of the joints a stop may tear the item off.
        """
        limits, plan = self.driver.cell.robot.limits, self.plan
        held = [s for s in plan.segments if s.held is not None]
        if self.segment_at(self.trace.plan_times[-1]).held is None or not held:
            return limits
        times = plan.trajectory.times
        carries = (times[1:] > held[0].t_start) & (times[:-1] < held[-1].t_end)
        _, acceleration, jerk = (HARDER * each[carries].max(axis=0) for each in peaks(plan.trajectory))
        return replace(
            limits,
            acceleration=np.clip(acceleration, LEAST_STOP * limits.acceleration, limits.acceleration),
            jerk=np.clip(jerk, LEAST_STOP * limits.jerk, limits.jerk),
        )

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

    def set_point(self, q: Array, t_plan: float) -> None:
        """Send a set point, wait for a period, and judge what was measured.

        Args:
            q: (n,) configuration.
            t_plan: s of the plan.
        """
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
            self.set_point(q, t_plan)
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


def _end_of_sealing(plan: Plan) -> float | None:
    """End time (s) of a plan's rest on the item to be picked; None if it does not rest there."""
    ends = [s.t_end for s in plan.segments if s.kind is SegmentKind.CONTACT and plan.grasp is not None]
    is_at_rest = bool(ends) and float(np.abs(plan.trajectory.sample(ends[0], 1)).max()) < REST_TOLERANCE
    return ends[0] if is_at_rest else None
