"""Stitching of a pick from a running conveyor, and its proof in space and time.

Every run is timed as if the belt stood, and joined so. Then the axis along the belt gets its motion with
the belt on top (``timing.line_tracking``). While the tool works on the belt, the result is proven free of
what rides on it as seen from there, and of the hall wherever along its axis the arm may be on a way off the
belt; before and after that, of all that what rides on the belt may come to.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pickcli.collision.collision_world import build_world
from pickcli.collision.motion_segment import at_rest, scaled_segments
from pickcli.errors import Failures, Reason
from pickcli.grasping.holding import GripLoad
from pickcli.io_events.resolve import delay_segments
from pickcli.motion.plan import LineTracking, Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.planning.assembly.carried_motion import CarriedMotion, carried_motion
from pickcli.planning.assembly.grip_load import carried_load
from pickcli.planning.assembly.pick_plan import pick_plan, why_too_slow
from pickcli.planning.assembly.proven_timing import BETWEEN
from pickcli.planning.assembly.timed_motion_validation import why_not_proven, why_not_swept
from pickcli.planning.belt_picks.belt_proof import (
    SceneSegment,
    bound_in_time,
    run_of,
    segments_of,
    why_not_free,
    without,
)
from pickcli.planning.pick_motion import GraspMotion, GraspTransit, PickMotion
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import Scene
from pickcli.timing.concatenation import RestingRun, delayed
from pickcli.timing.limit_check import LIMIT_TOLERANCE, PeakRatio, measure_limits
from pickcli.timing.line_tracking import MOST_PACE, TrackedMotion, relative_to_belt, shifted
from pickcli.timing.plan_parts import PlanPart, joined
from pickcli.timing.timed_run import TimedRun

PACED_LEAVING = MOST_PACE**-3  # of the limits: off the belt the plan still has its pace, cubed in the jerk


@dataclass(frozen=True, eq=False)
class TimedTaking:
    """The lines of a grasp relative to the belt, timed.

    Attributes:
        problem: The pick with the belt where the lines were planned.
        t_planned: s at which the belt is there.
        motion: The lines.
        inward: The run to the item.
        outward: The runs with it.
        rest: s for which the arm rests relative to the belt when the item is taken.
    """

    problem: PickProblem
    t_planned: float
    motion: GraspMotion
    inward: TimedRun
    outward: CarriedMotion
    rest: float

    @property
    def lasts(self) -> float:
        """Time (s) from the contact until the item is off the belt."""
        return self.rest + sum(part.run.trajectory.duration + part.rest for part in self.outward.parts)


@dataclass(frozen=True)
class Ramp:
    """How the axis along the belt comes up to its speed, or to rest again.

    Attributes:
        duration: s.
        rests: Whether the rest of the arm rests meanwhile; otherwise it is still on its way there, or leaves
            already, which is quicker, and may be more than axis or cup bear.
    """

    duration: float
    rests: bool


@dataclass(frozen=True, eq=False)
class Arrival:
    """The way to where the lines of a grasp begin.

    Attributes:
        reached: The transit, as if the belt stood.
        run: The transit, timed.
        rising: How the axis comes up to the belt's speed.
    """

    reached: GraspTransit
    run: TimedRun
    rising: Ramp

    @property
    def rest(self) -> float:
        """Time (s) between the transit and the lines."""
        return self.rising.duration if self.rising.rests else 0.0


@dataclass(frozen=True, eq=False)
class Meeting:
    """Arm and item at one place at one time.

    Attributes:
        scene: Scene at the start of the plan.
        coming: That scene with all that the items on the belt may come to.
        tracking: The conveyor.
        axis: Index of the joint along the belt.
        speed: m/s of that joint that keeps up with the belt, negative against its direction.
        falling: How it comes to rest again.
        t_contact: s from the start of the plan at which the contact is made.
        after: The pick with all that the items on the belt may come to once the tool has left it.
    """

    scene: Scene
    coming: Scene
    tracking: LineTracking
    axis: int
    speed: float
    falling: Ramp
    t_contact: float
    after: PickProblem


def stitch_tracked(
    meeting: Meeting, arrival: Arrival, taking: TimedTaking, carried: PickMotion
) -> Plan | Failures | float:
    """Time and prove a pick from a running conveyor, and bind its events.

    Args:
        meeting: Where and when the item is met.
        arrival: The way to where the lines begin.
        taking: The lines relative to the belt.
        carried: The transfer from where the arm is at rest again, with the placement.

    Returns:
        The plan, uncertified; every reason against it; or the s by which the meeting has to be later, for a
        device that needs the time.
    """
    context = taking.problem.context
    timed = _timed(meeting, arrival, taking, carried)
    if isinstance(timed, Failures):
        return timed
    relative, segments = joined([*timed.coming, *timed.tracking, *timed.leaving])
    relative, segments = delayed(relative, timed.wait), delay_segments(segments, timed.wait)
    scheduled = bound_in_time(context, segments, relative)
    if not isinstance(scheduled, tuple):
        return scheduled
    segments, relative, events = scheduled
    trajectory = timed.tracked.added_to(relative)
    if (too_slow := why_too_slow(taking.problem, trajectory, segments, taking.motion.grasp)) is not None:
        return Failures.of(too_slow)
    leaving = trajectory.between(timed.tracked.t_leaving, timed.tracked.t_end)
    if not meeting.falling.rests and (slow := why_too_slow_at_pace(context, leaving)) is not None:
        why = f"coming to rest from the belt's speed: {slow}"
        return Failures.of(Reason("joint too slow", str(taking.motion.grasp), why))
    proofs = _proofs(meeting, taking, carried, timed)
    as_seen = relative_to_belt(trajectory, meeting.axis, meeting.speed, taking.t_planned)
    at_work = partial(_why_not_free_at_work, meeting, taking, (trajectory, as_seen))
    unproven = why_not_free(context, proofs, trajectory, segments, at_work)
    if unproven is not None:
        return Failures.of(unproven)
    load = _load(meeting, taking, carried, timed, trajectory, segments)
    if isinstance(load, Failures):
        return load
    bound, grasp = (segments, trajectory, events), load.of(taking.motion.grasp)
    return pick_plan(taking.problem, meeting.scene, bound, grasp, meeting.tracking)


@dataclass(frozen=True, eq=False)
class _TimedParts:
    """All parts of a plan, timed as if the belt stood, with the motion of the axis that is added to them.

    coming, tracking, leaving: parts up to where the axis begins to follow the belt, relative to the belt, and
        from there on
    n_away: number of segments after the release
    tracked: the motion of the axis with the belt
    wait: s at rest before the first part
    transfer_load: the worst load on the cup in the transfer
    """

    coming: list[PlanPart]
    tracking: list[PlanPart]
    leaving: list[PlanPart]
    n_away: int
    tracked: TrackedMotion
    wait: float
    transfer_load: GripLoad


def _timed(
    meeting: Meeting, arrival: Arrival, taking: TimedTaking, carried: PickMotion
) -> _TimedParts | Failures:
    """Time all parts, each along the axis where it is in its own time."""
    context = taking.problem.context
    carried = paced_leaving(carried)
    transfer = carried_motion(meeting.after, replace(carried, taking=replace(carried.taking, outward=())))
    if isinstance(transfer, Failures):
        return transfer
    rests = context.method.rests(context.cell.devices, context.settings.release_time)
    closes = context.method.closes_at_rest
    t_up = meeting.t_contact - taking.inward.trajectory.duration
    t_left, falling = meeting.t_contact + taking.lasts, meeting.falling
    tracked = TrackedMotion(
        meeting.axis, meeting.speed, t_up - arrival.rising.duration, t_up, t_left, t_left + falling.duration
    )
    met = meeting.speed * (meeting.t_contact - taking.t_planned) - _offset(tracked, meeting.t_contact)
    end = -_offset(tracked, tracked.t_end)
    transit = scaled_segments(context.cell.speed_scale, [arrival.reached.transit])
    inward = scaled_segments(context.cell.speed_scale, taking.motion.inward)
    to_item = PlanPart(inward, taking.inward, rests.taking, taking.motion.inward[-1] if closes else None)
    leaves = at_rest(SegmentKind.TRANSFER, carried.taking.end, carried.transfer.segments[0].mode)
    slowing = RestingRun.of(context.arm.names, carried.taking.end, falling.duration)
    left = (
        *([PlanPart([leaves], slowing, continues=True)] if falling.rests else []),
        *transfer.parts,
        *transfer.away,
    )
    return _TimedParts(
        coming=[PlanPart(transit, arrival.run, arrival.rest)],
        tracking=[_along(part, meeting.axis, met) for part in (to_item, *taking.outward.parts)],
        leaving=[_along(part, meeting.axis, end) for part in left],
        n_away=sum(len(part.segments) for part in transfer.away),
        tracked=tracked,
        wait=t_up - arrival.rest - arrival.run.trajectory.duration,
        transfer_load=transfer.load,
    )


def why_too_slow_at_pace(context: PlanningContext, trajectory: Trajectory) -> PeakRatio | None:
    """Say which joint is too slow for a motion at the most of the pace at which a plan follows its belt.

    Args:
        context: The cell and its models.
        trajectory: The motion.

    Returns:
        Its ratio to a limit at the pace of the plan; None if all limits are kept at the most of it.
    """
    most = measure_limits(trajectory, context.arm.limits, context.cell.speed_scale)
    if most.time_scale * MOST_PACE <= 1.0 + LIMIT_TOLERANCE:
        return None
    return max(most.velocity, most.acceleration, most.jerk, key=lambda peak: peak.ratio)


def paced_leaving(carried: PickMotion) -> PickMotion:
    """Return a motion whose way with the item to its placement leaves room for the pace of a faster belt.

    Args:
        carried: The motion.

    Returns:
        The motion, with that way slowed down.
    """
    transfer, inward = carried.transfer, carried.placement.inward
    placement = replace(carried.placement, inward=tuple(each.scaled(PACED_LEAVING) for each in inward))
    segments = tuple(each.scaled(PACED_LEAVING) for each in transfer.segments)
    return replace(carried, transfer=replace(transfer, segments=segments, placement=placement))


def _offset(tracked: TrackedMotion, t: float) -> float:
    """Return how far the axis has come along with the belt at a time (s), m."""
    return float(tracked.offset(np.array([t]))[0][0])


def _proofs(
    meeting: Meeting, taking: TimedTaking, carried: PickMotion, timed: _TimedParts
) -> list[SceneSegment]:
    """Return what is to be proven, one for each segment of the plan."""
    scenes = [meeting.after.scene] * (len(after := segments_of(timed.leaving)) - timed.n_away)
    return [
        *(SceneSegment(meeting.coming, segment) for segment in segments_of(timed.coming)),
        *(SceneSegment(taking.problem.scene, segment) for segment in segments_of(timed.tracking)),
        *(
            SceneSegment(scene, segment)
            for scene, segment in zip(scenes + [carried.placement.scene] * timed.n_away, after, strict=True)
        ),
    ]


def _load(
    meeting: Meeting, taking: TimedTaking, carried: PickMotion, timed: _TimedParts, trajectory: Trajectory,
    segments: Sequence[Segment],
) -> GripLoad | Failures:  # fmt: skip
    """Return the worst load, also while the axis comes to rest; or that it is more than the tool bears."""
    context, motion = meeting.after.context, taking.motion
    hold = taking.problem.hold(motion.grasp.face, motion.attached.T_tip_item)
    released = max(segment.t_end for segment in segments if segment.held is not None)
    leaving = trajectory.between(timed.tracked.t_leaving, released)
    load = carried_load(context.arm, motion.holding_state, leaving, hold)
    if load.ratio > context.settings.load_ratio * (1.0 + BETWEEN):
        held = f"{load} as the axis comes to rest, {load.ratio:.2f} of the limit"
        return Failures.of(Reason("does not hold", str(motion.grasp), held))
    loads = [taking.outward.load, load]
    if len(carried.transfer.segments) > 1:  # the tool changes its state with the item
        loads.append(timed.transfer_load)
    return GripLoad.worst(loads)


def _along(part: PlanPart, axis: int, by: float) -> PlanPart:
    """Return a part whose run is shifted along an axis by some m."""
    return replace(part, run=replace(part.run, trajectory=shifted(part.run.trajectory, axis, by)))


def _why_not_free_at_work(
    meeting: Meeting, taking: TimedTaking, motions: tuple[Trajectory, Trajectory],
    proof: SceneSegment, segment: Segment,
) -> Reason | None:  # fmt: skip
    """Explain why a segment is not proven free while the tool works on the belt.

    motions: in the hall, and as the belt sees it
    """
    trajectory, as_seen = motions
    context, axis, mode = taking.problem.context, meeting.axis, proof.segment.mode
    target = {taking.problem.target.id}
    riding = {item.id for item in proof.scene.in_location(taking.problem.place.name)}
    others = set(build_world(context.model, proof.scene).names) - riding
    # What is worked on is met where it is planned to be: displaced, the touch would count as too deep.
    run = run_of(as_seen, segment)
    met = context.checker_for(proof.scene, without(others | riding - target, mode))
    if (unproven := why_not_proven(run, [proof.segment], [met])) is not None:
        return unproven
    off = np.full(len(trajectory.times), meeting.tracking.deviation)
    beside = context.checker_for(proof.scene, without(others | target, mode))
    if (unproven := why_not_swept(as_seen, segment, beside, axis, (-off, off))) is not None:
        return unproven
    # On a way off the belt the axis goes on with that while the lines are gone back, or on.
    q, limits = trajectory.positions[:, axis], context.arm.limits
    anywhere = (limits.lower[axis] - q, limits.upper[axis] - q)
    hall = context.checker_for(proof.scene, without(riding, mode))
    return why_not_swept(trajectory, segment, hall, axis, anywhere)
