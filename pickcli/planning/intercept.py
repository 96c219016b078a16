"""``plan_intercept``: a pick from a running conveyor, met at the earliest time at which the arm can be there.

Relative to the belt its items stand still, so grasp and lines are those of a pick from a table. Where no
linear axis runs along the belt, all joints follow it (``arm_intercept``). Where one does, that axis alone
follows it: every other joint moves as if the belt stood (``timing.line_tracking``). The same lines make
another meeting by another position of that axis. The arm waits at rest until it is time, comes up to the
speed of the belt over the item, and is at rest again after the lift.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.device import DeviceKind
from pickcli.collision.motion_segment import Mode, MotionSegment, scaled_segments
from pickcli.errors import Failures, NoPlanError, Reason
from pickcli.geometry import Array
from pickcli.kinematics.arm import LIMIT_MARGIN
from pickcli.kinematics.linear_axis import linear_axis
from pickcli.motion.plan import Certify, Plan
from pickcli.path_planning.path_cost import estimated_duration
from pickcli.planning.arm_intercept import plan_arm_intercept, why_unmet
from pickcli.planning.assembly.carried_motion import CarriedMotion, carried_motion
from pickcli.planning.assembly.proven_timing import proven_run
from pickcli.planning.assembly.tracked_stitching import Arrival, Meeting, Ramp, TimedTaking, stitch_tracked
from pickcli.planning.belt_query import InterceptQuery, QueryBelt
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_motion import GraspMotion, PickMotion, PlaceMotion, Transfer
from pickcli.planning.pick_problem import PickProblem, PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.stages.belt_raise import raised_over_belt
from pickcli.planning.stages.grasp_selection import feasible_grasps
from pickcli.planning.stages.grasp_transit import transits_to_grasps
from pickcli.planning.stages.line_pace import line_pace, paced_lines
from pickcli.planning.stages.reach_table import BeltTimes, least_times, too_late_by
from pickcli.planning.stages.transfer import plan_transfer
from pickcli.planning.start_state import Start
from pickcli.scene.item_stream import ItemStream
from pickcli.scene.scene import Scene
from pickcli.timing.line_tracking import BACK, MOST_PACE, ramp_time

USUAL_ARRIVAL = 2.0  # s from the start until the contact, about which grasps are searched
LATER = 0.01  # s that a meeting is put off beyond the time that the arm needs
ELSEWHERE = 0.25  # s that a meeting is put off if it cannot be reached for another reason
# Where on the way from the soonest to the last time in the window grasps are searched, until one is met.
WHERE_PLANNED = (0.5, 0.15, 0.85)
GENTLER = 2.0  # times the duration of a ramp during which the arm leaves already: accelerations add up
PACED_COMING = 0.9  # of the limits for the way to it, whose time is that of the belt
TURNED = 0.35  # s in which a way off the belt turns back, and the axis comes to rest at its end
WIDELY = 0.25  # s too late at one place of the belt, for which others are not tried: a rule, not a proof
MOST_MEETINGS = 8  # that are tried for one grasp
MOST_PACED = 3  # times that lines with the item are slowed down
KEPT = 0.97  # of the velocity that is left, between points of the trajectory
SLOWEST = 0.1  # of their speed, at which they would last too long
STILL = 1e-6  # m/s of an axis that does not move


@dataclass(frozen=True, eq=False)
class _Belt(QueryBelt):
    """The belt, and the axis along it.

    axis: index of the joint along the belt
    speed: m/s of that joint that keeps up with the belt, negative against its direction
    pace: share of the limits for lines on the belt
    ramp: s that it takes to come up to that speed
    """

    axis: int
    speed: float
    pace: float
    ramp: float


@dataclass(frozen=True, eq=False)
class _Window:
    """The lines of one grasp, and the s between which contact may be made."""

    taking: TimedTaking
    earliest: float
    latest: float


def plan_intercept(
    context: PlanningContext,
    stream: ItemStream,
    query: InterceptQuery,
    start: Start,
    seed: int = 0,
    certify: Certify | None = None,
) -> Plan:
    """Plan the pick of an item that rides on a conveyor; from a belt that stands, as from any place.

    Args:
        context: The cell, its models and its precomputed files.
        stream: The items on the conveyor.
        query: The requested pick.
        start: Configuration and tool state in which the robot is at rest.
        seed: Seed of all random choices.
        certify: Returns the plan with its certificate, or the reasons for its rejection; None leaves plans
            uncertified.

    Returns:
        The plan, valid for ``stream.scene_at(query.now)``.

    Raises:
        UnknownNameError: There is no such item or destination.
        NoPlanError: The item cannot be met, with every reason.
    """
    began = time.perf_counter()
    stream.find(query.item)
    scene, place = stream.scene_at(query.now), next(iter(stream.carrier.places))
    picked = PickQuery(place, query.item, query.into)
    if stream.speed == 0.0:
        return plan_pick(context, scene, picked, start, seed, certify=certify)
    if linear_axis(context.cell.robot, stream.carrier.T_world_carrier[:3, 0]) is None:
        return plan_arm_intercept(context, QueryBelt.of(stream, scene, query), query, start, seed, certify)
    belt = _belt_in_time(context, stream, scene, query, start)
    standing = context.checker_for(scene, Mode(start.tool_state))
    if not standing.is_valid(start.q):
        raise NoPlanError(query.label(place), [standing.explain(start.q).at("start")])
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
            if tried.delay > WIDELY:
                break
        if has_grasp:
            break
    raise NoPlanError(query.label(place), failures)


def why_never(
    context: PlanningContext, stream: ItemStream, query: InterceptQuery, start: Start
) -> NoPlanError | None:
    """Tell by bounds alone, in about a millisecond, that there is no plan.

    Args:
        context: The cell and its models.
        stream: The items on a conveyor that runs.
        query: The requested pick.
        start: Configuration and tool state in which the robot is at rest.

    Returns:
        The error that ``plan_intercept`` would raise; None if a search may find a plan.
    """
    scene = stream.scene_at(query.now)
    try:
        if linear_axis(context.cell.robot, stream.carrier.T_world_carrier[:3, 0]) is None:
            return why_unmet(context, QueryBelt.of(stream, scene, query), query)
        _belt_in_time(context, stream, scene, query, start)
    except NoPlanError as error:
        return error
    return None


def _belt_in_time(
    context: PlanningContext, stream: ItemStream, scene: Scene, query: InterceptQuery, start: Start
) -> _Belt:
    """Describe the belt for a query; raise NoPlanError if bounds tell that the item cannot be met."""
    belt, placed = _belt(context, stream, scene, query), scene.find(query.item)
    times = BeltTimes(
        stream.travel_at(stream.find(query.item), query.now), stream.speed, belt.speed, belt.axis,
        belt.first, belt.last, belt.ramp,
    )  # fmt: skip
    late = too_late_by(context, stream.carrier, scene, placed, start.q, times)
    if late > 0.0:
        soon = f"by {1e3 * late:.0f} ms at least, as the arm takes items there"
        place = next(iter(stream.carrier.places))
        raise NoPlanError(query.label(place), [Reason("too late", query.item, soon)])
    return belt


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
    belt: _Belt,
    t_planned: float,
    start: Start,
    certify: Certify | None,
    began: float,
) -> _Tried:
    """Try the grasps with the belt where it is at a time (s), until there is a plan.

    began: when the query did, by the clock of its statistics
    """
    grasps, failures = feasible_grasps(problem, ())
    timely, against, delay = _timely(belt, problem, t_planned, grasps, start)
    windows, others = _windows(problem, timely, belt, t_planned, start)
    failures, grasped = failures + against + others, time.perf_counter()
    arrivals = [_arrival(problem.context, belt, window, start) for window in windows]
    for k in sorted(range(len(windows)), key=arrivals.__getitem__):
        plan = _met(belt, windows[k], start, arrivals[k])
        if not isinstance(plan, Failures):
            took = 1e3 * (grasped - began), 1e3 * (time.perf_counter() - began)
            plan = plan.with_statistics(grasps_ms=took[0], planning_ms=took[1])
            plan = plan if certify is None else certify(plan)
        if not isinstance(plan, Failures):
            return _Tried(plan, failures)
        failures += plan
    if len(windows) == len(timely) > 0:
        delays = (t - window.latest for t, window in zip(arrivals, windows, strict=True))
        delay = min(delay, *delays)
    elif timely or not grasps:
        delay = -np.inf
    return _Tried(None, failures, bool(grasps), delay)


def _timely(
    belt: _Belt, problem: PickProblem, t_planned: float, grasps: Sequence[GraspMotion], start: Start
) -> tuple[list[GraspMotion], Failures, float]:
    """Return the grasps that the arm may be in time for, the reasons against others, their least delay (s).

    By bounds of their lines, at much less effort than by timing them; lines that are lengthened, and their
    acceleration, take longer still.
    """
    context, timely, failures, least = problem.context, list[GraspMotion](), Failures(), np.inf
    taking = context.method.rests(context.cell.devices, context.settings.release_time).taking
    for motion in grasps:
        near = motion.unwound_towards(context.arm.limits, start.q)
        reached = float(least_times(context, start.q, near.start[None], belt.axis)[0])
        inward, outward = (_least_time(context, part) for part in (near.inward, near.outward))
        latest = _between(belt, context, near, t_planned, (inward, taking + outward))[1]
        late = reached + belt.ramp + inward - latest
        if late > 0.0:
            least = min(least, late)
            failures += Reason("too late", str(motion.grasp), f"by {1e3 * late:.0f} ms at least")
        else:
            timely.append(motion)
    return timely, failures, least


def _least_time(context: PlanningContext, segments: Sequence[MotionSegment]) -> float:
    """Bound the duration (s) of straight lines by the greatest speeds of the tool."""
    total = 0.0
    for segment in segments:
        tips = context.arm.tips(segment.waypoints[[0, -1]], segment.mode.tool_state)[:, :3, 3]
        if segment.limits.max_tool_speed is not None:
            total += float(np.linalg.norm(tips[1] - tips[0])) / segment.limits.max_tool_speed
    return total


def _belt(context: PlanningContext, stream: ItemStream, scene: Scene, query: InterceptQuery) -> _Belt:
    """Describe the belt for a query; raise NoPlanError if the item cannot be reached at any time."""
    queried = QueryBelt.of(stream, scene, query)
    found = linear_axis(context.cell.robot, stream.carrier.T_world_carrier[:3, 0])
    assert found is not None
    axis, direction = found
    limits = context.arm.limits
    scale = context.cell.speed_scale

    def never(detail: str) -> NoPlanError:
        where = f"{query.item} at {query.now:g} s"
        return NoPlanError(query.label(stream.conveyor), [Reason("joint too slow", where, detail)])

    if MOST_PACE * stream.speed >= scale * limits.velocity[axis]:
        slow = f"{context.arm.names[axis]} reaches {scale * limits.velocity[axis]:g} m/s"
        raise never(f"{slow}, the belt runs at {stream.speed:g} m/s, and the arm catches up")
    left = scale * float(limits.acceleration[axis]) - stream.belt.max_acceleration
    if left <= 0.0:
        hard = f"{context.arm.names[axis]} accelerates no faster than the belt"
        raise never(f"{hard}, {stream.belt.max_acceleration:g} m/s2")
    pace = line_pace(limits, stream.belt.max_acceleration / stream.speed)
    ramp = ramp_time(stream.speed, left, pace * float(limits.jerk[axis]))
    rows = queried.stream, queried.now, queried.start, queried.first, queried.last
    return _Belt(*rows, axis, direction * stream.speed, pace, ramp, meets=queried.meets)


def _windows(
    problem: PickProblem, grasps: Sequence[GraspMotion], belt: _Belt, t_planned: float, start: Start
) -> tuple[list[_Window], Failures]:
    """Find when the arm can follow the lines of grasps, planned with the belt where it is at a time (s)."""
    found, failures = list[_Window](), Failures()
    for motion in grasps:
        unwound = motion.unwound_towards(problem.context.arm.limits, start.q)
        raised = raised_over_belt(problem, unwound, belt.coming, belt.left(t_planned))
        window = raised if isinstance(raised, Failures) else _window(problem, belt, raised, t_planned)
        if isinstance(window, Failures):
            failures += window
        else:
            found.append(window)
    return found, failures


def _window(problem: PickProblem, belt: _Belt, motion: GraspMotion, t_planned: float) -> _Window | Failures:
    """Time the lines of a grasp relative to the belt, and find when the arm can follow them."""
    context = problem.context
    motion = paced_lines(motion, belt.pace)
    inward = proven_run(context, problem.scene, scaled_segments(context.cell.speed_scale, motion.inward))
    if isinstance(inward, Failures):
        return inward
    lifted = _lifted(problem, belt, motion)
    if isinstance(lifted, Failures):
        return lifted
    motion, outward = lifted
    rests = context.method.rests(context.cell.devices, context.settings.release_time)
    taking = TimedTaking(problem, t_planned, motion, inward, outward, rests.taking)
    lasting = inward.trajectory.duration, taking.lasts
    earliest, latest = _between(belt, context, motion, t_planned, lasting)
    if earliest > latest:
        lacking = abs(belt.speed) * (earliest - latest)
        short = f"{context.arm.names[belt.axis]} and the window are {lacking:.2f} m too short"
        return Failures.of(Reason("out of the window", str(motion.grasp), short))
    return _Window(taking, earliest, latest)


def _lifted(
    problem: PickProblem, belt: _Belt, motion: GraspMotion
) -> tuple[GraspMotion, CarriedMotion] | Failures:
    """Time the lines with the item, as slow as the axis needs for them besides the belt.

    Joints carry an item at a share of their velocity; the belt takes some of that of the axis along it.
    """
    context, nowhere = problem.context, Transfer((), PlaceMotion(problem.scene, (), (), 0.0))
    share = context.cell.speed_scale * problem.target.item.speed_scale
    left = share * float(context.arm.limits.velocity[belt.axis]) - abs(belt.speed)
    for _ in range(MOST_PACED):
        outward = carried_motion(problem, PickMotion(motion.inward[0], motion, nowhere))
        if isinstance(outward, Failures):
            return outward
        along_belt = [
            np.sign(belt.speed) * part.run.trajectory.velocities[:, belt.axis] for part in outward.parts
        ]
        fastest = float(max(speeds.max() for speeds in along_belt))
        if fastest <= max(left, STILL):
            return motion, outward
        slower = KEPT * left / fastest
        if slower < SLOWEST:
            break
        motion = replace(motion, outward=tuple(_slowed(each, slower) for each in motion.outward))
    item, axis = problem.target.item.name, context.arm.names[belt.axis]
    carries = f"{axis} carries {item} at {left + abs(belt.speed):g} m/s at most"
    needed = f"the belt runs at {abs(belt.speed):g} m/s, and the lines need {fastest:.3f} m/s"
    return Failures.of(Reason("joint too slow", str(motion.grasp), f"{carries}; {needed}"))


def _slowed(segment: MotionSegment, by: float) -> MotionSegment:
    """Scale the limits of a line, the tool's speed among them."""
    slow, cap = segment.scaled(by), segment.limits.max_tool_speed
    return replace(slow, limits=replace(slow.limits, max_tool_speed=None if cap is None else by * cap))


def _between(
    belt: _Belt, context: PlanningContext, motion: GraspMotion, t_planned: float, lasting: tuple[float, float]
) -> tuple[float, float]:
    """Return the s between which contact may be made, by the window and the axis.

    motion: lines, planned with the belt where it is at t_planned (s)
    lasting: s of them until the contact, and from there until the item is off the belt
    """
    inward, lasts = lasting
    v, axis, limits = belt.speed, belt.axis, context.arm.limits
    # The axis begins and ends its way along the belt half a ramp's travel before and after the lines.
    begins = motion.start[axis] - v * (inward + belt.ramp / 2)
    ends = motion.end[axis] + v * (lasts + belt.ramp / 2)
    lower, upper = limits.lower[axis] + LIMIT_MARGIN, limits.upper[axis] - LIMIT_MARGIN
    first, last = (lower, upper) if v > 0.0 else (upper, lower)
    sign = float(np.sign(v))
    earliest = max(belt.first, t_planned + float((first - begins) / v))
    # Stopped where it meets the item, the arm goes back along the lines, and the axis on with the belt.
    back = motion.start[axis] + v * (inward / BACK + TURNED)
    farthest = sign * max(sign * ends, sign * back)
    latest = min(belt.last - lasts, t_planned + float((last - farthest) / v))
    if belt.meets is not None:
        earliest, latest = max(earliest, belt.meets), min(latest, belt.meets)
    return earliest, latest


def along(motion: GraspMotion, axis: int, by: float) -> GraspMotion:
    """Shift the lines of a grasp along an axis.

    Args:
        motion: The lines.
        axis: Index of the joint.
        by: m.

    Returns:
        The shifted lines.
    """
    way = np.zeros(len(motion.start))
    way[axis] = by
    inward, outward = (tuple(s.unwound(way) for s in part) for part in (motion.inward, motion.outward))
    return replace(motion, inward=inward, outward=outward)


def _arrival(context: PlanningContext, belt: _Belt, window: _Window, start: Start) -> float:
    """Estimate the earliest s of contact."""
    late = window.earliest - window.taking.inward.trajectory.duration - window.taking.t_planned
    ready = along(window.taking.motion, belt.axis, belt.speed * late)
    transit = estimated_duration(context.space, np.stack([start.q, ready.start]))
    pumps = (each.lead for each in context.cell.devices.values() if each.kind is DeviceKind.PUMP)
    moved = transit + belt.ramp + window.taking.inward.trajectory.duration
    return max(window.earliest, moved, *pumps)


def _met(belt: _Belt, window: _Window, start: Start, t_contact: float) -> Plan | Failures:
    """Plan the earliest meeting that the arm is in time for, from the s of contact that are estimated."""
    failures = Failures()
    for _ in range(MOST_MEETINGS):
        if t_contact > window.latest:
            late = f"by {1e3 * (t_contact - window.latest):.0f} ms"
            return failures + Reason("too late", str(window.taking.motion.grasp), late)
        found = _planned(belt, window.taking, start, t_contact)
        if isinstance(found, Plan):
            too_far = belt.brought_too_far(found, str(window.taking.motion.grasp))
            return found if too_far is None else failures + too_far
        if isinstance(found, Failures):
            failures += found
            found = ELSEWHERE
        t_contact += found
    return failures


def _planned(belt: _Belt, taking: TimedTaking, start: Start, t_contact: float) -> Plan | Failures | float:
    """Plan the meeting at a time; return the reasons against it, or the s by which it has to be later."""
    arrival = _arrived(belt, taking, start, t_contact)
    if not isinstance(arrival, Arrival):
        return arrival
    failures = Failures()
    for falling in (Ramp(GENTLER * belt.ramp, False), Ramp(belt.ramp, True)):
        plan = _left(belt, taking, arrival, t_contact, falling)
        if not isinstance(plan, Failures):
            return plan
        failures += plan
    return failures


def _arrived(belt: _Belt, taking: TimedTaking, start: Start, t_contact: float) -> Arrival | Failures | float:
    """Plan the transit to where the axis begins to follow the belt, in time for a contact."""
    problem, context = taking.problem, taking.problem.context
    t_lines = t_contact - taking.inward.trajectory.duration
    # The axis begins its way along the belt as if that were half of the ramp away.
    late = t_lines - belt.ramp / 2 - taking.t_planned
    ready = along(taking.motion, belt.axis, belt.speed * late)
    if (beyond := _beyond_limits(belt, taking, ready.start)) is not None:
        return Failures.of(beyond)
    before = replace(problem, scene=belt.coming)
    reached = next(transits_to_grasps(before, [ready], start))
    if isinstance(reached, Failures):
        return reached
    reached = replace(reached, transit=reached.transit.scaled(PACED_COMING))
    segments = scaled_segments(context.cell.speed_scale, [reached.transit])
    transit = proven_run(context, before.scene, segments)
    if isinstance(transit, Failures):
        return transit
    missing = transit.trajectory.duration + belt.ramp - t_lines
    return missing + LATER if missing > 0.0 else Arrival(reached, transit, belt.ramp)


def _left(
    belt: _Belt, taking: TimedTaking, arrival: Arrival, t_contact: float, falling: Ramp
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
    return stitch_tracked(meeting, arrival, taking, carried)


def _beyond_limits(belt: _Belt, taking: TimedTaking, q: Array) -> Reason | None:
    """Say that a configuration (n,) is beyond the limits of the axis along the belt, if it is."""
    arm = taking.problem.context.arm
    lower, upper = arm.limits.lower[belt.axis], arm.limits.upper[belt.axis]
    if lower <= q[belt.axis] <= upper:
        return None
    return Reason("joint limit", str(taking.motion.grasp), f"{arm.names[belt.axis]} at {q[belt.axis]:.3f}")
