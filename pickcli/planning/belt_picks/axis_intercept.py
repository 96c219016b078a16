"""A pick from a running conveyor that a linear axis along it follows, met at the earliest time that is found.

Grasps and lines are searched with the belt at a few places. The arm waits at rest until it is time. The axis
comes up to the speed of the belt while the arm is still on its way, where it has the acceleration for both,
else while the arm rests over the item; it comes to rest again as the arm leaves with the item, or before.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np

from pickcli.collision.motion_segment import scaled_segments
from pickcli.errors import Failures, NoPlanError, Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Certify, Plan
from pickcli.path_planning.path_cost import estimated_duration
from pickcli.planning.assembly.proven_timing import proven_run
from pickcli.planning.belt_picks.axis_windows import (
    AxisBelt,
    ContactWindow,
    along,
    axis_belt,
    contact_window,
    timely_grasps,
)
from pickcli.planning.belt_picks.belt_query import (
    PACED_COMING,
    WIDELY_LATE,
    InterceptQuery,
    QueryBelt,
    pumped_from,
)
from pickcli.planning.belt_picks.reach_table import BeltTimes, too_late_by
from pickcli.planning.belt_picks.tracked_stitching import (
    Arrival,
    Meeting,
    Ramp,
    TimedTaking,
    stitch_tracked,
    why_too_slow_at_pace,
)
from pickcli.planning.pick_problem import PickProblem, PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.stages.grasp_selection import feasible_grasps
from pickcli.planning.stages.grasp_transit import transits_to_grasps
from pickcli.planning.stages.transfer import plan_transfer
from pickcli.planning.start_state import Start
from pickcli.timing.concatenation import delayed
from pickcli.timing.line_tracking import TrackedMotion

USUAL_ARRIVAL = 2.0  # s from the start until the contact, about which grasps are searched
PACED_RISING = 0.8  # of the limits on the way to the belt, where its time is that of a belt that may change
LATER = 0.01  # s that a meeting is put off beyond the time that the arm needs
ELSEWHERE = 0.25  # s that a meeting is put off if it cannot be reached for another reason
# Where on the way from the soonest to the last time in the window grasps are searched, until one is met.
WHERE_PLANNED = (0.5, 0.15, 0.85)
GENTLER = 2.0  # times the duration of a ramp during which the arm leaves already: accelerations add up
GENTLEST = 3.0  # the same of leaving, where GENTLER is too quick
SOONER = 0.1  # s after which it is tried again whether the axis can come up to its speed on the way
MOST_MEETINGS = 8  # that are tried for one grasp


def plan_axis_intercept(
    context: PlanningContext,
    queried: QueryBelt,
    query: InterceptQuery,
    start: Start,
    seed: int = 0,
    certify: Certify | None = None,
) -> Plan:
    """Plan the pick of an item that rides on a conveyor with a linear axis along it.

    Args:
        context: The cell, its models and its precomputed files.
        queried: The belt as the query sees it.
        query: The requested pick.
        start: Configuration and tool state in which the robot is at rest.
        seed: Seed of all random choices.
        certify: Returns the plan with its certificate, or the reasons for its rejection; None leaves plans
            uncertified.

    Returns:
        The plan, valid for the scene at its start.

    Raises:
        NoPlanError: The item cannot be met, with every reason.
    """
    began = time.perf_counter()
    belt = axis_belt(context, queried, query)
    place = next(iter(belt.stream.carrier.places))
    picked = PickQuery(place, query.item, query.into)
    failures = Failures()
    soonest = min(belt.last, max(belt.first, USUAL_ARRIVAL))
    # As the table has it; other configurations are for what the arm cannot take so at all.
    for by_named in (True, False) if context.configurations_at(context.cell.places[place]) else (False,):
        has_grasp = False
        for share in WHERE_PLANNED:
            t_planned = soonest + share * (belt.last - soonest)
            problem = PickProblem.of(context, belt.at(t_planned), picked, seed)
            problem = replace(problem, by_named=by_named, over_rim=True)
            tried = _tried(problem, belt, t_planned, start, certify, began)
            if tried.plan is not None:
                return tried.plan
            failures, has_grasp = failures + tried.failures, has_grasp or tried.has_grasp
            if tried.delay > WIDELY_LATE:
                break
        if has_grasp:
            break
    raise NoPlanError(query.label(place), failures)


def why_out_of_time(
    context: PlanningContext, queried: QueryBelt, query: InterceptQuery, start: Start
) -> NoPlanError | None:
    """Say that an item cannot be met, by the speed of the axis and a table of least times alone.

    Args:
        context: The cell.
        queried: The belt as the query sees it.
        query: The requested pick.
        start: Configuration and tool state in which the robot is at rest.

    Returns:
        The error; None if there may be a meeting.
    """
    try:
        return _too_late(context, axis_belt(context, queried, query), query, start)
    except NoPlanError as error:
        return error


def _too_late(
    context: PlanningContext, belt: AxisBelt, query: InterceptQuery, start: Start
) -> NoPlanError | None:
    """Say that the arm is too late for an item wherever it takes it, by the table of least times."""
    stream, placed = belt.stream, belt.start.find(query.item)
    times = BeltTimes(
        stream.travel_at(stream.find(query.item), query.now), stream.speed, belt.speed, belt.axis,
        belt.first, belt.last, belt.ramp,
    )  # fmt: skip
    late = too_late_by(context, stream.carrier, belt.start, placed, start.q, times)
    if late <= 0.0:
        return None
    soon = f"by {1e3 * late:.0f} ms at least, as the arm takes items there"
    place = next(iter(stream.carrier.places))
    return NoPlanError(query.label(place), [Reason("too late", query.item, soon)])


@dataclass(frozen=True, eq=False)
class _Tried:
    """What came of the grasps with the belt at one place.

    plan: certified, if certificates are wanted; None without one
    failures: reasons against the others
    has_grasp: whether the arm can take the item at all
    delay: s by which all grasps are too late at least; -inf if not all are, or for other reasons
    """

    plan: Plan | None
    failures: Failures
    has_grasp: bool = True
    delay: float = -np.inf


def _tried(
    problem: PickProblem,
    belt: AxisBelt,
    t_planned: float,
    start: Start,
    certify: Certify | None,
    began: float,
) -> _Tried:
    """Try the grasps with the belt where it is at a time (s), the soonest first, until there is a plan.

    began: when the query did, by the clock of its statistics
    """
    grasps, failures = feasible_grasps(problem, ())
    timely, against, delay = timely_grasps(belt, problem, t_planned, grasps, start)
    failures, grasped = failures + against, time.perf_counter()
    for motion in timely:
        window = contact_window(problem, motion, belt, t_planned, start)
        if isinstance(window, Failures):
            failures, delay = failures + window, -np.inf
            continue
        t_contact = _arrival(problem.context, belt, window, start)
        plan = _met(belt, window, start, t_contact)
        if not isinstance(plan, Failures):
            took = 1e3 * (grasped - began), 1e3 * (time.perf_counter() - began)
            plan = plan.with_statistics(grasps_ms=took[0], planning_ms=took[1])
            plan = plan if certify is None else certify(plan)
        if not isinstance(plan, Failures):
            return _Tried(plan, failures)
        failures, delay = failures + plan, min(delay, t_contact - window.latest)
    return _Tried(None, failures, bool(grasps), delay if grasps else -np.inf)


def _arrival(context: PlanningContext, belt: AxisBelt, window: ContactWindow, start: Start) -> float:
    """Estimate the earliest s of contact."""
    late = window.earliest - window.taking.inward.trajectory.duration - window.taking.t_planned
    ready = along(window.taking.motion, belt.axis, belt.speed * late)
    transit = estimated_duration(context.space, np.stack([start.q, ready.start]))
    moved = transit + window.taking.inward.trajectory.duration
    return max(window.earliest, moved, pumped_from(context.cell))


def _met(belt: AxisBelt, window: ContactWindow, start: Start, t_contact: float) -> Plan | Failures:
    """Plan the earliest meeting that the arm is in time for, from the s of contact that are estimated."""
    failures, latest, missing = Failures(), window.latest, t_contact - window.latest
    for _ in range(MOST_MEETINGS):
        if t_contact > latest:
            break
        found = _planned(belt, window.taking, start, t_contact)
        if isinstance(found, Plan):
            too_far = belt.brought_too_far(found, str(window.taking.motion.grasp))
            return found if too_far is None else failures + too_far
        failures, missing = failures + found.failures, t_contact + found.late - latest
        later = t_contact + found.by
        # Tried in steps, it is also tried at the last moment.
        t_contact = latest if found.by != found.late and t_contact < latest < later else later
    if missing > 0.0:
        late = f"by about {1e3 * missing:.0f} ms"
        failures += Reason("too late", str(window.taking.motion.grasp), late)
    return failures


@dataclass(frozen=True, eq=False)
class _PutOff:
    """A meeting that cannot be at a time.

    late: s that the arm is too late for it, 0 if it is not
    by: s after which it is tried again
    failures: reasons against it at that time
    """

    late: float
    by: float
    failures: Failures


def _planned(belt: AxisBelt, taking: TimedTaking, start: Start, t_contact: float) -> Plan | _PutOff:
    """Plan the meeting at a time, with the axis coming up to its speed on the way, or at its end."""
    failures, late = Failures(), list[float]()
    gently, resting = Ramp(GENTLER * belt.ramp, False), Ramp(belt.ramp, True)
    for rising in (gently, resting):
        arrival = _arrived(belt, taking, start, t_contact, rising)
        if isinstance(arrival, float):
            late.append(arrival)
            continue
        if isinstance(arrival, Failures):
            failures += arrival
            continue
        for falling in (gently, Ramp(GENTLEST * belt.ramp, False), resting):
            plan = _left(belt, taking, arrival, t_contact, falling)
            if isinstance(plan, Plan):
                return plan
            if isinstance(plan, float):
                late.append(plan)
            else:
                failures += plan
    if not late:
        return _PutOff(0.0, ELSEWHERE, failures)
    return _PutOff(min(late), min(SOONER, *late) if failures else min(late), failures)


def _arrived(
    belt: AxisBelt, taking: TimedTaking, start: Start, t_contact: float, rising: Ramp
) -> Arrival | Failures | float:
    """Plan the transit to where the lines of a grasp begin, in time for a contact."""
    problem, context = taking.problem, taking.problem.context
    t_lines = t_contact - taking.inward.trajectory.duration
    # The axis begins its way along the belt as if that were half of the ramp away.
    late = t_lines - rising.duration / 2 - taking.t_planned
    ready = along(taking.motion, belt.axis, belt.speed * late)
    if (beyond := _beyond_limits(belt, taking, ready.start)) is not None:
        return Failures.of(beyond)
    before = replace(problem, scene=belt.coming)
    reached = next(transits_to_grasps(before, [ready], start))
    if isinstance(reached, Failures):
        return reached
    reached = replace(reached, transit=reached.transit.scaled(PACED_COMING if rising.rests else PACED_RISING))
    segments = scaled_segments(context.cell.speed_scale, [reached.transit])
    transit = proven_run(context, before.scene, segments)
    if isinstance(transit, Failures):
        return transit
    arrival = Arrival(reached, transit, rising)
    missing = max(transit.trajectory.duration + arrival.rest, rising.duration) - t_lines
    if missing > 0.0:
        return missing + LATER
    too_slow = None if rising.rests else _why_too_slow(belt, taking, arrival)
    return arrival if too_slow is None else Failures.of(too_slow)


def _why_too_slow(belt: AxisBelt, taking: TimedTaking, arrival: Arrival) -> Reason | None:
    """Say which joint is too slow to come up to the belt's speed on the way, at the most of its pace."""
    context, transit = taking.problem.context, arrival.run.trajectory
    t_up = max(transit.duration, arrival.rising.duration)
    begins = t_up - arrival.rising.duration
    rises = TrackedMotion(belt.axis, belt.speed, begins, t_up, t_up + belt.ramp, t_up + 2.0 * belt.ramp)
    summed = rises.added_to(delayed(transit, t_up - transit.duration)).between(0.0, t_up)
    slow = why_too_slow_at_pace(context, summed)
    why = f"coming up to the belt's speed: {slow}"
    return None if slow is None else Reason("joint too slow", str(taking.motion.grasp), why)


def _left(
    belt: AxisBelt, taking: TimedTaking, arrival: Arrival, t_contact: float, falling: Ramp
) -> Plan | Failures | float:
    """Plan the way from the belt to the placement, and stitch the whole plan."""
    # The axis ends its way along the belt as if that had gone on for half of the ramp.
    t_after = t_contact + taking.lasts + falling.duration / 2
    left = along(taking.motion, belt.axis, belt.speed * (t_after - taking.t_planned))
    if (beyond := _beyond_limits(belt, taking, left.end)) is not None:
        return Failures.of(beyond)
    scene = belt.left(t_contact + taking.lasts)
    after = replace(taking.problem, scene=scene)
    carried = plan_transfer(after, replace(arrival.reached, taking=left))
    if isinstance(carried, Failures):
        return carried
    meeting = Meeting(
        belt.start, belt.coming, belt.tracking, belt.axis, belt.speed, falling, t_contact, after
    )
    plan = stitch_tracked(meeting, arrival, taking, carried)
    return plan.with_statistics(**arrival.reached.figures) if isinstance(plan, Plan) else plan


def _beyond_limits(belt: AxisBelt, taking: TimedTaking, q: Array) -> Reason | None:
    """Say that a configuration (n,) is beyond the limits of the axis along the belt, if it is."""
    arm = taking.problem.context.arm
    lower, upper = arm.limits.lower[belt.axis], arm.limits.upper[belt.axis]
    if lower <= q[belt.axis] <= upper:
        return None
    return Reason("joint limit", str(taking.motion.grasp), f"{arm.names[belt.axis]} at {q[belt.axis]:.3f}")
