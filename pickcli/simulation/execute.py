"""Carry out a plan: stream it, fire its events by measured progress, watch what holds, keep the record."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from pickcli.cell.device import DeviceKind
from pickcli.geometry import Array
from pickcli.io_events.tracker import EventTracker
from pickcli.kinematics.arm import Arm
from pickcli.motion.event import Event
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.progress import Progress, ProgressObserver
from pickcli.simulation.braking import Return
from pickcli.simulation.contact_guard import ContactGuard
from pickcli.simulation.execution import Execution, Fall, FiredEvent
from pickcli.simulation.grip import Release
from pickcli.simulation.places import bounds
from pickcli.simulation.planned_contacts import PlannedContacts
from pickcli.simulation.protective_stop import ProtectiveStop, StopCause
from pickcli.simulation.start_check import at_the_robot, check_start
from pickcli.simulation.stream import Pace, Stream, full_speed, stream, violations
from pickcli.simulation.supervision import Supervisor
from pickcli.simulation.trigger import TriggerDistance
from pickcli.simulation.world import World

END_TIME = 0.1  # s after the last set point: the servo arrives, the last events fire
FALL_TIME = 0.6  # s instead, when something broke away and still falls
BEHIND = 0.02  # s of the plan: contacts end so much after the robot has left the segment that plans them
STANDING = 0.02  # rad/s or m/s of every joint, below which a stopping robot stands
MOST_BRAKING = 1.0  # s in which the heaviest joint stands from full speed
SEAL_TIME = 1.5  # s beyond the plan's own rest on an item: a line that leaked is evacuated to 0.95 by then
AT_REST = 1e-6  # rad/s or m/s of every joint
RETURN_TIME = 0.3  # s from standstill beside the path to standstill on it
YIELD_TIME = 0.5  # s after a contact in which the robot may go back along its path to where nothing presses
YIELD_PACE = 0.1  # of the plan's pace, backwards
FREE = 0.5  # of what stops a motion: what stands just under that would stop the next one at once
FREE_TIME = 0.03  # s for which nothing presses any more: what is measured is noisy
TRACE_STEPS = 10  # between two looks at the tool's lag
PROGRESS_STEPS = 100  # between two reports of progress

OnStep = Callable[[World], None]


def execute(
    plan: Plan,
    world: World,
    *,
    pace: Pace = full_speed,
    on_progress: ProgressObserver | None = None,
    on_step: OnStep | None = None,
) -> Execution:
    """Carry out a plan in a world, to its end or to a stop on its path.

    On the item the robot rests until the vacuum is there, at most for ``SEAL_TIME`` longer than planned. It
    stops when it does not follow, feels a contact that no plan explains, meets its item too early, when the
    vacuum does not stand where the plan counts on it, when fingers stand closer together or farther apart
    than what they should hold is wide, or when the vacuum sensor reads that nothing is held, and it stands.
    Pump and valve are switched off only before the lift, or where the vacuum itself has broken down: a sensor
    may be wrong, and what it denies would be dropped.

    Args:
        plan: The plan.
        world: The world.
        pace: How fast the plan's time passes; for tests of pauses and slow robots.
        on_progress: Called every 0.1 s with the seconds of the plan and its segment.
        on_step: Called after every time step, e.g. to film.

    Returns:
        What happened.

    Raises:
        StaleError: If the plan is for another cell.
        StartError: If the robot is not where the plan begins.
        InputError: If the tool is in another state than the plan begins with.
    """
    plan = at_the_robot(plan, world)
    check_start(plan, world)
    return _Run(plan, world, pace, on_progress, on_step).play()


@dataclass
class _Trace:
    """What is noted on the way."""

    fired: list[FiredEvent] = field(default_factory=list)
    sent: list[Array] = field(default_factory=list)  # set points
    plan_times: list[float] = field(default_factory=list)  # of each set point
    told: list[Array] = field(default_factory=list)  # every TRACE_STEPS: set point and measured
    measured: list[Array] = field(default_factory=list)


class _Run:
    """One execution in progress."""

    def __init__(
        self,
        plan: Plan,
        world: World,
        pace: Pace,
        on_progress: ProgressObserver | None,
        on_step: OnStep | None,
    ) -> None:
        self.plan, self.world, self.pace = plan, world, pace
        self.on_progress, self.on_step = on_progress, on_step
        self.tracker = EventTracker(plan.trajectory, plan.segments, plan.events)
        self.distance = TriggerDistance(plan, Arm(world.robot))
        self.trace = _Trace()
        self.t_start = world.t
        self.n_releases = len(world.grip.releases)
        self.n_steps = 0
        self.max_load = 0.0
        self.stop: ProtectiveStop | None = None
        self.stopped_in: Segment | None = None
        self.supervisor = Supervisor(world, Arm(world.robot))
        self.guard = ContactGuard(world, Arm(world.robot), plan, self.supervisor.external)
        self.path_time: float | None = None
        self.n_judged: int | None = None  # set points to which the planned limits apply; all, if None
        self.t_standing: float | None = None
        self._q_before = world.q
        self._ends = [segment.t_end for segment in plan.segments]
        self._starts = [segment.t_start for segment in plan.segments]
        self._allowed_in: tuple[int, int] | None = None  # of the segments, whose contacts are allowed now
        self.t_sealed = _end_of_sealing(plan)

    def play(self) -> Execution:
        self._send(stream(self.plan.trajectory, self.world.time_step, self.pace))
        if self.stop is not None:
            self._brake(self.stop)
        has_lost = self.stop is not None and self.stop.cause.has_lost_item
        for _ in range(round((FALL_TIME if has_lost else END_TIME) / self.world.time_step)):
            self._step()
        # Where it stands now it may go on touching what it was to touch there.
        return self._record()

    def _send(self, commands: Stream) -> None:
        is_braking = self.stop is not None
        for q, t_plan in zip(commands.points, commands.plan_times.tolist(), strict=True):
            if self._lifts_off(t_plan):
                self._wait_for_hold()
            if self.stop is None or is_braking:
                self._set_point(q, t_plan)
            if self.stop is not None and not is_braking:
                return

    def _set_point(self, q: Array, t_plan: float) -> None:
        self.trace.sent.append(q)
        self.trace.plan_times.append(t_plan)
        self._allow_contacts(t_plan)
        self.world.command(q)
        self._step()
        if self.stop is None and (why := self._reason_to_stop(q, t_plan)):
            self.stop, self.stopped_in = why, self._segment(t_plan)

    def _lifts_off(self, t_plan: float) -> bool:
        """Whether the next set point is the first after the rest in which the tool takes hold."""
        if self.stop is not None or self.t_sealed is None or not self.trace.sent:
            return False
        return self.trace.plan_times[-1] <= self.t_sealed < t_plan

    def _wait_for_hold(self) -> None:
        """Rest on the item until the tool has taken hold; at most for a while."""
        world, q, t_plan = self.world, self.trace.sent[-1], self.trace.plan_times[-1]
        t_end = world.t + SEAL_TIME
        while world.t < t_end and not self._has_hold():
            self._set_point(q, t_plan)
            if self.stop is not None:
                return

    def _has_hold(self) -> bool:
        """Whether the tool has taken hold of the item as the plan counts on it."""
        assert self.plan.grasp is not None
        seal = self.world.scene.find(self.plan.grasp.item).item.seals.get(self.plan.grasp.face, 0.0)
        return self.world.tool.has_hold(seal)

    def _step(self) -> None:
        world, trace = self.world, self.trace
        world.step()
        if self.stop is not None and self.t_standing is None:
            speed = np.abs(world.q - self._q_before).max() / world.time_step
            self.t_standing = world.t if speed < STANDING else None
        self._q_before = world.q
        if self.stop is None:
            for event in self.tracker.update(world.q, world.time_step):
                self._fire(event)
        # Until the lift an item that the cup has sealed on still stands; what it bears builds up.
        if world.held is not None and self._segment(trace.plan_times[-1]).held is not None:
            self.max_load = max(self.max_load, world.grip.ratio)
        self.n_steps += 1
        if self.n_steps % TRACE_STEPS == 0:
            trace.told.append(trace.sent[-1])
            trace.measured.append(world.q)
        if self.n_steps % PROGRESS_STEPS == 0 and self.on_progress is not None:
            t_plan = trace.plan_times[-1]
            kind = str(self._segment(t_plan).kind)
            self.on_progress(Progress(t_plan, self.plan.trajectory.duration, kind))
        if self.on_step is not None:
            self.on_step(world)

    def _fire(self, event: Event) -> None:
        reading = self.world.act(event.device, event.action)
        distance = self.distance(event, self.world.q, self.trace.plan_times[-1])
        self.trace.fired.append(FiredEvent(event, self.world.t, distance, reading))

    def _releases(self) -> tuple[Release, ...]:
        return tuple(self.world.grip.releases[self.n_releases :])

    def _reason_to_stop(self, command: Array, t_plan: float) -> ProtectiveStop | None:
        fired, segment = self.trace.fired, self._segment(min(self.tracker.progress, t_plan))
        if self.world.reality.supervision and (
            stop := self.supervisor.motion(command, segment) or self.guard.update(segment)
        ):
            return stop
        if stop := self.supervisor.hold(segment):
            return stop
        if fired and fired[-1].reading is False:
            return ProtectiveStop(StopCause.SENSOR, fired[-1].event.device, 0.0, 1.0, "", self.world.t)
        return None

    def _brake(self, why: ProtectiveStop) -> None:
        """Come to a stand on the planned path."""
        if why.cause in (StopCause.CONTACT, StopCause.FOLLOWING_ERROR):
            self._brake_hard()
            return
        from pickcli.timing.stopping_trajectory import stop

        is_released = why.cause in (StopCause.SEAL_LOST, StopCause.NOT_SEALED, StopCause.EARLY_CONTACT)
        for device in self.world.scene.cell.devices.values():
            if is_released and device.kind in (DeviceKind.PUMP, DeviceKind.VALVE):
                self.world.act(device.name, "off")
        t_plan = self.trace.plan_times[-1]
        halted = stop(self.plan.trajectory, t_plan, self.world.robot.limits)
        self.path_time = halted.path_time
        t = len(self.trace.sent) * self.world.time_step
        self._send(stream(halted.trajectory, self.world.time_step, self.pace, t_plan, t))

    def _brake_hard(self) -> None:
        """Brake every joint with all the torque that its motor has, wherever that leaves the path.

        Then lead the arm onto the path again, and back along it while something presses. What is held stays
        held.
        """
        world, trajectory = self.world, self.plan.trajectory
        self.n_judged = len(self.trace.sent)
        progress = min(self.tracker.progress, self.trace.plan_times[-1])
        t_end = world.t + MOST_BRAKING
        while self.t_standing is None and world.t < t_end:
            self._follow(world.q, progress)
        led = Return(trajectory, progress, world.q, RETURN_TIME)
        while not led.is_on_path:
            self._follow(led.advance(world.time_step), led.path_time)
        t_end, t_free = world.t + YIELD_TIME, world.t + FREE_TIME
        while world.t < min(t_end, t_free):
            self._follow(led.back(world.time_step, YIELD_PACE), led.path_time)
            if self.supervisor.pressing() > FREE:
                t_free = world.t + FREE_TIME
        self.path_time = led.path_time

    def _follow(self, q: Array, t_plan: float) -> None:
        """One set point of a stop."""
        self.trace.sent.append(q)
        self.trace.plan_times.append(t_plan)
        self.world.command(q)
        self._step()
        self.supervisor.feel()

    def _segment(self, t_plan: float) -> Segment:
        return self.plan.segments[min(bisect_left(self._ends, t_plan), len(self._ends) - 1)]

    def _allow_contacts(self, t_plan: float) -> None:
        """Allow the contacts of all segments between where the robot is and where it is told to be."""
        behind = min(self.tracker.progress, t_plan) - BEHIND
        first, last = bisect_left(self._ends, behind), bisect_right(self._starts, t_plan)
        if (first, last) != self._allowed_in:
            self._allowed_in, now = (first, last), self.plan.segments[first:last]
            self.world.planned = PlannedContacts.of(self.plan, now, self.world.robot.tool)

    def _record(self) -> Execution:
        world, plan, trace = self.world, self.plan, self.trace
        cell = world.scene.cell
        judged = slice(self.n_judged)
        commands = Stream(np.array(trace.plan_times[judged]), np.array(trace.sent[judged]))
        releases = self._releases()
        fired = {id(f.event) for f in trace.fired}
        return Execution(
            t_start=self.t_start,
            t_end=world.t,
            stop=self.stop,
            stopped_in=self.stopped_in.kind if self.stopped_in else None,
            events=tuple(trace.fired),
            missed=() if self.stop else tuple(e for e in plan.events if id(e) not in fired),
            collisions=world.contacts.since(self.t_start),
            limit_violations=violations(
                commands, plan.trajectory.joint_names, cell.robot.limits, world.time_step, cell.speed_scale
            ),
            releases=releases,
            falls=tuple(fall_of(world, release) for release in releases),
            held=world.held,
            max_lag=self._max_lag(),
            max_load=self.max_load,
            path_time=self.path_time,
            stopping_time=self._stopping_time(),
        )

    def _stopping_time(self) -> float | None:
        if self.stop is None:
            return None
        return (self.world.t if self.t_standing is None else self.t_standing) - self.stop.t

    def _max_lag(self) -> float:
        if not self.trace.told:
            return 0.0
        arm = Arm(self.world.robot)
        state = self.world.robot.tool.default_state
        told = arm.tips(np.array(self.trace.told), state)
        measured = arm.tips(np.array(self.trace.measured), state)
        return float(np.linalg.norm((told - measured)[:, :3, 3], axis=1).max())


def _end_of_sealing(plan: Plan) -> float | None:
    """The time (s) at which a plan ends its rest on what it picks; None where it does not rest there."""
    ends = [s.t_end for s in plan.segments if s.kind is SegmentKind.CONTACT and plan.grasp is not None]
    is_at_rest = bool(ends) and float(np.abs(plan.trajectory.sample(ends[0], 1)).max()) < AT_REST
    return ends[0] if is_at_rest else None


def fall_of(world: World, release: Release) -> Fall:
    """How far an item that left the cup has fallen by now.

    Args:
        world: The world.
        release: When and where it left.

    Returns:
        The fall.
    """
    before, after = world.scene.find(release.item), world.engine.pose(release.item)
    bottoms = [bounds(before.item.shape, T)[0][2] for T in (release.T_world_item, after)]
    return Fall(release.item, max(0.0, float(bottoms[0] - bottoms[1])), release.is_wanted)
