"""Executes plans in the simulated world, with supervision of contacts and hold, and records them."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable
from dataclasses import replace

from pickcli.geometry import Array, inverse
from pickcli.motion.plan import Plan
from pickcli.progress import ProgressObserver
from pickcli.seeds import derived_rng
from pickcli.simulation.belt_run import HARD, BeltRun
from pickcli.simulation.braking import Return
from pickcli.simulation.contact_guard import ContactGuard
from pickcli.simulation.execution import Execution, Fall
from pickcli.simulation.grip import Release
from pickcli.simulation.operator_stop import OperatorSignal, never, random_stops, signal_of
from pickcli.simulation.places import bounds
from pickcli.simulation.plan_run import PathMotion
from pickcli.simulation.planned_contacts import PlannedContacts
from pickcli.simulation.protective_stop import ProtectiveStop
from pickcli.simulation.start_check import at_the_robot, check_start
from pickcli.simulation.stream import Pace, full_speed
from pickcli.simulation.supervision import Supervisor
from pickcli.simulation.weight_watch import WeightWatch
from pickcli.simulation.world import World

FALL_TIME = 0.6  # s of simulation at the end if an item was lost or dropped and is falling
CONTACT_TIME_MARGIN = 0.02  # s of the plan by which allowed contacts outlast the segment that plans them
RETURN_TIME = 0.3  # s for the return onto the path, from rest to rest
YIELD_TIME = 0.5  # s after a contact in which the robot may move back along its path until nothing presses
YIELD_PACE = 0.1  # speed of that motion, as a share of the plan's
# share of the stop threshold: a force just below it would stop the next motion at once
FREE_FORCE_SHARE = 0.5
FREE_TIME = 0.03  # s without pressure before the arm counts as free, as measurements are noisy

OnStep = Callable[[World], None]


def execute(
    plan: Plan,
    world: World,
    *,
    pace: Pace = full_speed,
    operator: OperatorSignal | None = None,
    on_progress: ProgressObserver | None = None,
    on_step: OnStep | None = None,
) -> Execution:
    """Carry out a plan in a world, to its end or to a stop on its path.

    On the item the robot waits until the vacuum has built up, at most ``SEAL_TIME`` longer than planned. It
    stops and stays at rest if a joint does not follow, if it feels an unplanned contact, if it meets its item
    too early, if what it carries cannot be the item by its weight, if the vacuum is lower than the plan
    requires, if the width of the fingers differs from that of the item, or if the vacuum sensor reads that
    nothing is held. Pump and valve are switched off only before the lift or if the vacuum itself has broken
    down: a sensor may be wrong, and the item would be dropped.

    Args:
        plan: The plan.
        world: The world.
        pace: Speed of the plan's time; for tests of pauses and slow robots.
        operator: Whether the operator stops the robot, which then stays at rest on its path and goes on; over
            a running belt it leaves that first, and ends if the item was not met yet. None for random stops
            by the level of the world's reality.
        on_progress: Called every 0.1 s with the seconds of the plan and its segment.
        on_step: Called after every time step, e.g. to film.

    Returns:
        The record of the execution.

    Raises:
        StaleError: The plan is for another cell.
        StartError: The robot is not where the plan begins.
        InputError: The tool is in another state than at the start of the plan.
    """
    plan = at_the_robot(plan, world)
    check_start(plan, world)
    run = _Run(plan, world, pace, on_progress, on_step)
    run.operator = operator or _random_operator(plan, world)
    run.play()
    t_end = world.t
    run.let_fall()
    return replace(run.execution(), t_end=t_end)


def _random_operator(plan: Plan, world: World) -> OperatorSignal:
    share = world.reality.operator_stop_share
    if share == 0.0:
        return never
    rng = derived_rng(world.seed, "operator", world.t)
    return signal_of(random_stops(share, plan.trajectory.duration, rng), world.t)


class _Run(BeltRun[World]):
    """Run of a plan in the simulated world, which has more measurements than a driver."""

    def __init__(
        self,
        plan: Plan,
        world: World,
        pace: Pace,
        on_progress: ProgressObserver | None,
        on_step: OnStep | None,
    ) -> None:
        super().__init__(plan, world, pace, on_progress, on_step)
        self.world = world
        self.n_releases = len(world.grip.releases)
        self.max_load = 0.0
        held_at = None if plan.grasp is None else inverse(plan.grasp.T_item_tip)[:3, 3]
        self.supervisor = Supervisor(world, self.arm, p_tip_item=held_at)
        self.guard = ContactGuard(world, self.arm, plan, self.supervisor.external)
        self.weight = WeightWatch(world, self.arm, plan, self.supervisor.external)
        self._ends = [segment.t_end for segment in plan.segments]
        self._starts = [segment.t_start for segment in plan.segments]
        self._allowed_in: tuple[int, int] | None = None  # segments whose contacts are allowed

    def execution(self) -> Execution:
        """Return the record, with collisions, releases and falls from the world."""
        world, releases = self.world, self._releases()
        return Execution(
            **vars(self.record()),
            collisions=world.contacts.since(self.t_start),
            releases=releases,
            falls=falls_of(world, releases),
            held=world.held,
            max_load=self.max_load,
        )

    def let_fall(self) -> None:
        """Let what was dropped at the very end of a plan at a belt come to rest, to see where it lies."""
        world, from_belt = self.world, self.plan.tracking is not None
        while from_belt and any(world.t - release.t < FALL_TIME for release in self._releases()):
            self.step()

    @property
    def end_time(self) -> float:
        """Duration of the end, longer if an item falls. Planned contacts may continue meanwhile."""
        stops = self.stops_on_way_off if self.stop is None else (self.stop, *self.stops_on_way_off)
        has_lost = any(stop.cause.has_lost_item for stop in stops)
        return FALL_TIME if has_lost else super().end_time

    def before_set_point(self, t_plan: float) -> None:
        """Allow the contacts of all segments between the measured and the commanded time."""
        # Back along its lines the robot comes from later segments.
        ahead = max(self.progress, t_plan) if self.stop is not None else t_plan
        behind = min(self.progress, t_plan) - CONTACT_TIME_MARGIN
        first, last = bisect_left(self._ends, behind), bisect_right(self._starts, ahead)
        if (first, last) != self._allowed_in:
            self._allowed_in, now = (first, last), self.plan.segments[first:last]
            self.world.planned = PlannedContacts.of(self.plan, now, self.world.robot.tool)

    def after_step(self) -> None:
        """Update the largest load, from the lift on: before that the sealed item still stands."""
        world = self.world
        if world.held is not None and self.segment_at(self.trace.plan_times[-1]).held is not None:
            self.max_load = max(self.max_load, world.grip.ratio)

    def has_hold(self) -> bool:
        """Whether the tool holds the item as well as the plan requires."""
        assert self.plan.grasp is not None
        scene, grasp = self.world.scene, self.plan.grasp
        placed = scene.find(grasp.item)
        return self.world.tool.has_hold(grasp, placed, scene.noise_of(placed))

    def _releases(self) -> tuple[Release, ...]:
        return tuple(self.world.grip.releases[self.n_releases :])

    def reason_to_stop(self, command: Array, t_plan: float) -> ProtectiveStop | None:
        """Check supervision and contact guard, then the hold, then the sensor, then the weight."""
        t_robot = min(self.progress, t_plan)
        segment = self.segment_at(t_robot)
        if self.world.reality.supervision and (
            stop := self.supervisor.motion(command, segment) or self.guard.update(segment, t_robot)
        ):
            return stop
        if stop := self.supervisor.hold(segment) or self.sensed_nothing():
            return stop
        return self.weight.update(segment) if self.world.reality.supervision else None

    def brake(self, why: ProtectiveStop) -> None:
        """Stop on the planned path; after a contact or following error as hard as possible."""
        if why.cause in HARD:
            at = min(self.progress, self.trace.plan_times[-1])
            self.brake_beside(PathMotion(self.plan.trajectory, lambda t: t), at)
            return
        self.release(why.cause)
        super().brake(why)

    def brake_beside(self, motion: PathMotion, at: float) -> None:
        """Brake every joint with the full torque of its motor, even if that leaves the path.

        Then lead the arm back onto the path, and back along it while something presses. A held item stays
        held.
        """
        world = self.world
        super().brake_beside(motion, at)
        led = Return(motion.trajectory, at, world.q, RETURN_TIME)
        while not led.is_on_path:
            self.send_beside(led.advance(world.time_step), motion.path_time(led.path_time))
        t_end, t_free = world.t + YIELD_TIME, world.t + FREE_TIME
        while world.t < min(t_end, t_free):
            q = led.back(world.time_step, YIELD_PACE)
            self.send_beside(q, motion.path_time(led.path_time))
            if self.supervisor.pressing() > FREE_FORCE_SHARE:
                t_free = world.t + FREE_TIME
        self.path_time = motion.path_time(led.path_time)

    def send_beside(self, q: Array, t_plan: float) -> None:
        """Send a set point of a stop beside the path, and measure what presses."""
        self.trace.sent.append(q)
        self.trace.plan_times.append(t_plan)
        self.world.command(q)
        self.step()
        self.supervisor.feel()


def falls_of(world: World, releases: Iterable[Release]) -> tuple[Fall, ...]:
    """Compute how far items have fallen since they left the tool.

    The rest of the vacuum may pull an item on again before it finally separates, so that one item can be
    released several times; its fall counts from the highest release, and as wanted only if all releases were.

    Args:
        world: The world.
        releases: Releases, with times and poses.

    Returns:
        One fall per item.
    """
    falls: dict[str, Fall] = {}
    for release in releases:
        item, after = world.scene.find(release.item).item, world.engine.pose(release.item)
        bottoms = [bounds(item.shape, T)[0][2] for T in (release.T_world_item, after)]
        known = falls.get(release.item, Fall(release.item, 0.0, True))
        height = max(known.height, float(bottoms[0] - bottoms[1]))
        falls[release.item] = replace(known, height=height, is_wanted=known.is_wanted and release.is_wanted)
    return tuple(falls.values())
