"""When an axis along a running belt can follow the lines of a grasp.

Relative to the belt its items stand still, so every joint but that axis moves as if the belt stood
(``timing.line_tracking``), and the same lines make another meeting by another position of that axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pickcli.collision.motion_segment import MotionSegment, scaled_segments
from pickcli.errors import Failures, NoPlanError, Reason
from pickcli.kinematics.arm import LIMIT_MARGIN
from pickcli.kinematics.linear_axis import linear_axis
from pickcli.path_planning.path_cost import estimated_duration
from pickcli.planning.assembly.carried_motion import CarriedMotion, carried_motion
from pickcli.planning.assembly.proven_timing import proven_run
from pickcli.planning.belt_picks.belt_query import InterceptQuery, QueryBelt
from pickcli.planning.belt_picks.belt_raise import higher_item, raised_over_belt
from pickcli.planning.belt_picks.line_pace import line_pace, paced_lines
from pickcli.planning.belt_picks.reach_table import least_times
from pickcli.planning.belt_picks.tracked_stitching import TimedTaking
from pickcli.planning.pick_motion import GraspMotion, PickMotion, PlaceMotion, Transfer
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.timing.line_tracking import BACK, MOST_PACE, ramp_time

TURNED = 0.275  # s that a way off the belt takes longer than its lines, as it turns back on them
MOST_PACED = 3  # times that lines with the item are slowed down
KEPT = 0.97  # of the velocity that is left, between points of the trajectory
SLOWEST = 0.1  # of their speed, at which they would last too long
STILL = 1e-6  # m/s of an axis that does not move


@dataclass(frozen=True, eq=False)
class AxisBelt(QueryBelt):
    """The belt, and the axis along it.

    Attributes:
        axis: Index of the joint along the belt.
        speed: m/s of that joint that keeps up with the belt, negative against its direction.
        pace: Share of the limits for lines on the belt.
        ramp: s that it takes to come up to that speed.
    """

    axis: int
    speed: float
    pace: float
    ramp: float


@dataclass(frozen=True, eq=False)
class ContactWindow:
    """The lines of one grasp, and the times between which contact may be made.

    Attributes:
        taking: The lines, timed relative to the belt.
        earliest: s from the start of the plan.
        latest: s from the start of the plan.
    """

    taking: TimedTaking
    earliest: float
    latest: float


def axis_belt(context: PlanningContext, queried: QueryBelt, query: InterceptQuery) -> AxisBelt:
    """Describe the belt for an arm with a linear axis along it.

    Args:
        context: The cell, in which there is such an axis.
        queried: The belt as the query sees it.
        query: The requested pick.

    Returns:
        The belt.

    Raises:
        NoPlanError: The axis is too slow for the belt.
    """
    stream = queried.stream
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
    return AxisBelt(*rows, axis, direction * stream.speed, pace, ramp, meets=queried.meets)


def timely_grasps(
    belt: AxisBelt, problem: PickProblem, t_planned: float, grasps: Sequence[GraspMotion], start: Start
) -> tuple[list[GraspMotion], Failures, float]:
    """Sort out the grasps for which the arm is too late, and order the others by how soon it may meet them.

    By bounds of their lines, at much less effort than by timing them; lines that are lengthened, and their
    acceleration, take longer still.

    Args:
        belt: The belt and the axis.
        problem: The pick, with the belt where it is at ``t_planned``.
        t_planned: s from the start of the plan.
        grasps: Grasps with their lines.
        start: Where the robot is at rest.

    Returns:
        The grasps that the arm may be in time for, the soonest first, the reasons against the others, and the
        s by which it is too late for those at least; inf without any.
    """
    context, timely, failures, least = problem.context, list[tuple[float, GraspMotion]](), Failures(), np.inf
    taking = context.method.rests(context.cell.devices, context.settings.release_time).taking
    for motion in grasps:
        near = motion.unwound_towards(context.arm.limits, start.q)
        reached = float(least_times(context, start.q, near.start[None], belt.axis)[0])
        inward, outward = (_least_time(context, part) for part in (near.inward, near.outward))
        earliest, latest = _between(belt, context, near, t_planned, (inward, taking + outward))
        late = max(reached, belt.ramp) + inward - latest
        if late > 0.0:
            least = min(least, late)
            failures += Reason(
                "too late", str(motion.grasp), f"by {1e3 * late:.0f} ms at least{belt.only_there}"
            )
        else:
            way = estimated_duration(context.space, np.stack([start.q, near.start]))
            timely.append((max(earliest, way + inward), motion))
    timely.sort(key=lambda each: each[0])
    return [motion for _, motion in timely], failures, least


def _least_time(context: PlanningContext, segments: Sequence[MotionSegment]) -> float:
    """Bound the duration (s) of straight lines by the greatest speeds of the tool."""
    total = 0.0
    for segment in segments:
        tips = context.arm.tips(segment.waypoints[[0, -1]], segment.mode.tool_state)[:, :3, 3]
        if segment.limits.max_tool_speed is not None:
            total += float(np.linalg.norm(tips[1] - tips[0])) / segment.limits.max_tool_speed
    return total


def contact_window(
    problem: PickProblem, motion: GraspMotion, belt: AxisBelt, t_planned: float, start: Start
) -> ContactWindow | Failures:
    """Find when the arm can follow the lines of a grasp.

    Args:
        problem: The pick, with the belt where it is at ``t_planned``.
        motion: The grasp with its lines.
        belt: The belt and the axis.
        t_planned: s from the start of the plan.
        start: Where the robot is at rest.

    Returns:
        The window, or the reasons why it cannot follow them.
    """
    unwound = motion.unwound_towards(problem.context.arm.limits, start.q)
    raised = raised_over_belt(problem, unwound, belt.coming, belt.left(t_planned))
    if isinstance(raised, Failures):
        return raised
    window = _window(problem, belt, raised, t_planned)
    is_raised = len(raised.inward) > len(unwound.inward) or len(raised.outward) > len(unwound.outward)
    if not isinstance(window, Failures) or not is_raised:
        return window
    higher = higher_item(problem, unwound, belt.coming, belt.left(t_planned))
    if higher == problem.target.id:
        return window
    over = f"{higher} that the belt may bring" if higher else "what the belt may bring"
    return Failures(tuple(replace(each, detail=f"{each.detail}; they lead over {over}") for each in window))


def _window(
    problem: PickProblem, belt: AxisBelt, motion: GraspMotion, t_planned: float
) -> ContactWindow | Failures:
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
        short = f"{context.arm.names[belt.axis]} and the window are {lacking:.3f} m too short for the lines"
        return Failures.of(Reason("out of the window", str(motion.grasp), f"{short}{belt.only_there}"))
    return ContactWindow(taking, earliest, latest)


def _lifted(
    problem: PickProblem, belt: AxisBelt, motion: GraspMotion
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
    belt: AxisBelt,
    context: PlanningContext,
    motion: GraspMotion,
    t_planned: float,
    lasting: tuple[float, float],
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
    stops = abs(v) / (2.0 * context.cell.speed_scale * float(limits.acceleration[axis]))
    back = motion.start[axis] + v * (inward / BACK + TURNED + stops)
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
