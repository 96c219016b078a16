"""Stitching of a pick from a running conveyor that the whole arm follows, and its proof in space and time.

The lines are timed as if the belt stood, with the rests of both ramps before and after them, and all joints
follow the belt from there (``timing.arm_tracking``). While the tool works on the belt, the result is proven
free of what rides on it as seen from there, by a robot that travels backwards on one more joint below its
base, and of the hall; before and after that, of all that what rides on the belt may come to.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np

from pickcli.cell.robots.travelling import travelling
from pickcli.collision.collision_world import build_world
from pickcli.collision.motion_segment import MotionSegment, at_rest, scaled_segments
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array
from pickcli.motion.plan import LineTracking, Plan, times_at_work
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.planning.assembly.carried_motion import carried_motion
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
from pickcli.planning.belt_picks.tracked_stitching import TimedTaking, paced_leaving
from pickcli.planning.pick_motion import GraspMotion, PickMotion
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import Scene
from pickcli.timing.arm_tracking import ArmTracking
from pickcli.timing.concatenation import RestingRun
from pickcli.timing.limit_check import measure_limits
from pickcli.timing.line_tracking import TrackedMotion
from pickcli.timing.plan_parts import PlanPart, joined
from pickcli.timing.timed_run import TimedRun

PARTS = 4  # of a quintic that are proven one by one, as the joints' motions cancel out as seen from the belt
ROOM = 0.9  # of the limits while the arm follows the belt, whose pace may change


@dataclass(frozen=True, eq=False)
class FollowedTaking:
    """The lines of a grasp, and the motion that follows the belt with them.

    Attributes:
        taking: The lines as if the belt stood at the contact, timed.
        along: (3,) unit vector in the world, in which the belt runs.
        speed: m/s of the belt.
        ramp: s in which the arm comes up to that speed, and to rest again.
        relative: The motion as if the belt stood, with rests for both ramps.
        segments: Its segments, the first and the last those of the ramps.
        times: s at which these begin, and at which the last one ends.
        trajectory: The motion in the hall.
    """

    taking: TimedTaking
    along: Array
    speed: float
    ramp: float
    relative: Trajectory
    segments: tuple[MotionSegment, ...]
    times: Array
    trajectory: Trajectory

    @property
    def t_contact(self) -> float:
        """Time (s) from the beginning of the motion to the contact."""
        return self.ramp + self.taking.inward.trajectory.duration

    @property
    def lasts(self) -> float:
        """Time (s) from the contact until the item is off the belt."""
        return self.taking.lasts

    @property
    def ready(self) -> GraspMotion:
        """The grasp, where the arm waits for the belt."""
        motion, first = self.taking.motion, self.segments[1]
        return replace(motion, inward=(at_rest(first.kind, self.trajectory.positions[0], first.mode),))

    @property
    def left(self) -> GraspMotion:
        """The grasp, where the arm is at rest again."""
        motion, last = self.taking.motion, self.taking.motion.outward[-1]
        return replace(motion, outward=(at_rest(last.kind, self.trajectory.positions[-1], last.mode),))

    def unwound(self, by: Array) -> FollowedTaking:
        """Shift the motion by whole turns of its joints.

        Args:
            by: (n,) rad.

        Returns:
            The shifted motion.
        """
        return replace(
            self,
            relative=replace(self.relative, positions=self.relative.positions + by),
            trajectory=replace(self.trajectory, positions=self.trajectory.positions + by),
            segments=tuple(segment.unwound(by) for segment in self.segments),
        )


@dataclass(frozen=True, eq=False)
class FollowedMeeting:
    """Arm and item at one place at one time.

    Attributes:
        scene: Scene at the start of the plan.
        coming: That scene with all that the items on the belt may come to.
        tracking: The conveyor.
        t_contact: s from the start of the plan at which the contact is made.
        after: The pick with all that the items on the belt may come to once the tool has left it.
    """

    scene: Scene
    coming: Scene
    tracking: LineTracking
    t_contact: float
    after: PickProblem


def follow_lines(taking: TimedTaking, along: Array, speed: float, ramp: float) -> FollowedTaking | Failures:
    """Let all joints follow a belt with the lines of a grasp.

    Args:
        taking: The lines as if the belt stood at the contact, timed.
        along: (3,) unit vector in the world, in which the belt runs.
        speed: m/s of the belt.
        ramp: s in which the arm comes up to that speed, and to rest again.

    Returns:
        The motion; or why the arm cannot follow.
    """
    context, motion = taking.problem.context, taking.motion
    names, closes = context.arm.names, context.method.closes_at_rest
    ready = at_rest(SegmentKind.TRANSIT, motion.start, motion.inward[0].mode)
    leaving = at_rest(SegmentKind.TRANSFER, motion.end, motion.outward[-1].mode)
    inward = scaled_segments(context.cell.speed_scale, motion.inward)
    parts = [
        PlanPart([ready], RestingRun.of(names, motion.start, ramp)),
        PlanPart(inward, taking.inward, taking.rest, motion.inward[-1] if closes else None),
        *taking.outward.parts,
        PlanPart([leaving], RestingRun.of(names, motion.end, ramp)),
    ]
    relative, timed = joined(parts)
    t_met = ramp + taking.inward.trajectory.duration
    tracked = TrackedMotion(0, speed, 0.0, ramp, relative.duration - ramp, relative.duration)
    state = motion.inward[0].mode.tool_state
    followed = ArmTracking(context.arm, state, along, relative, tracked, t_met).followed()
    if isinstance(followed, Reason):
        return Failures.of(followed.within(str(motion.grasp)))
    most = measure_limits(followed, context.arm.limits, context.cell.speed_scale)
    worst = max(most.velocity, most.acceleration, most.jerk, key=lambda peak: peak.ratio)
    if worst.ratio > ROOM:
        slow = f"following the belt: {worst}, {ROOM:g} is the most there"
        return Failures.of(Reason("joint too slow", str(motion.grasp), slow))
    times = np.array([timed[0].t_start, *(segment.t_end for segment in timed)])
    return FollowedTaking(taking, along, speed, ramp, relative, tuple(segments_of(parts)), times, followed)


def stitch_followed(
    meeting: FollowedMeeting, transit: MotionSegment, coming: TimedRun, followed: FollowedTaking,
    carried: PickMotion,
) -> Plan | Failures | float:  # fmt: skip
    """Time and prove a pick from a belt that the arm follows, and bind its events.

    Args:
        meeting: Where and when the item is met.
        transit: The way to where the arm waits for the belt.
        coming: The same, timed.
        followed: The motion on the belt.
        carried: The transfer from where the arm is at rest again, with the placement.

    Returns:
        The plan, uncertified; every reason against it; or the s by which the meeting has to be later, for a
        device that needs the time.
    """
    taking, context = followed.taking, followed.taking.problem.context
    carried = paced_leaving(carried)
    transfer = carried_motion(meeting.after, replace(carried, taking=replace(carried.taking, outward=())))
    if isinstance(transfer, Failures):
        return transfer
    wait = meeting.t_contact - followed.t_contact - coming.trajectory.duration
    work = RestingRun(followed.trajectory, followed.times, np.ones(len(followed.segments)))
    parts = [
        PlanPart(scaled_segments(context.cell.speed_scale, [transit]), coming, wait, continues=True),
        PlanPart(followed.segments, work, continues=True),
        *transfer.parts,
        *transfer.away,
    ]
    trajectory, segments = joined(parts)
    scheduled = bound_in_time(context, segments, trajectory)
    if not isinstance(scheduled, tuple):
        return scheduled
    segments, trajectory, events = scheduled
    if (too_slow := why_too_slow(taking.problem, trajectory, segments, taking.motion.grasp)) is not None:
        return Failures.of(too_slow)
    n_away = sum(len(part.segments) for part in transfer.away)
    proofs = _proofs(meeting, taking, carried, parts, segments, n_away)
    at_work = partial(_why_not_free_at_work, meeting, followed, trajectory)
    unproven = why_not_free(context, proofs, trajectory, segments, at_work)
    if unproven is not None:
        return Failures.of(unproven)
    hold = taking.problem.hold(taking.motion.grasp.face, taking.motion.attached.T_tip_item)
    taken = next(s.t_start for s in segments if s.held is not None)
    released = max(s.t_end for s in segments if s.held is not None)
    load = carried_load(context.arm, taking.motion.holding_state, trajectory.between(taken, released), hold)
    if load.ratio > context.settings.load_ratio * (1.0 + BETWEEN):
        held = f"{load} following the belt, {load.ratio:.2f} of the limit"
        return Failures.of(Reason("does not hold", str(taking.motion.grasp), held))
    bound, grasp = (segments, trajectory, events), load.of(taking.motion.grasp)
    return pick_plan(taking.problem, meeting.scene, bound, grasp, meeting.tracking)


def _proofs(
    meeting: FollowedMeeting, taking: TimedTaking, carried: PickMotion, parts: Sequence[PlanPart],
    segments: Sequence[Segment], n_away: int,
) -> list[SceneSegment]:  # fmt: skip
    """Return what is to be proven, one for each segment of the plan."""
    t_works, t_left = times_at_work(segments)
    found = []
    for k, (each, segment) in enumerate(zip(segments_of(parts), segments, strict=True)):
        if segment.t_start < t_works:
            scene = meeting.coming
        elif segment.t_start < t_left:
            scene = taking.problem.scene
        else:
            scene = meeting.after.scene if k < len(segments) - n_away else carried.placement.scene
        found.append(SceneSegment(scene, each))
    return found


def _why_not_free_at_work(
    meeting: FollowedMeeting, followed: FollowedTaking, trajectory: Trajectory, proof: SceneSegment,
    segment: Segment,
) -> Reason | None:  # fmt: skip
    """Explain why a segment is not proven free while the tool works on the belt."""
    problem, moving = followed.taking.problem, proof.segment
    context, scene, mode = problem.context, proof.scene, moving.mode
    target = {problem.target.id}
    riding = {item.id for item in scene.in_location(problem.place.name)}
    run = run_of(trajectory, segment)
    hall = context.checker_for(scene, without(riding, mode))
    if (unproven := why_not_proven(run, [moving], [hall])) is not None:
        return unproven
    seen = _seen_from_belt(context, meeting.tracking.conveyor)
    seen_scene = replace(scene, cell=seen.cell)
    others = set(build_world(seen.model, seen_scene).names) - riding
    travel = -followed.speed * (trajectory.times - meeting.t_contact)
    as_seen = _with_travel(trajectory, seen.cell.robot.joint_names, travel, -followed.speed)
    # What is worked on is met where it is planned to be: displaced, the touch would count as too deep.
    met = seen.checker_for(seen_scene, without(others | riding - target, mode))
    run = replace(run, trajectory=as_seen)
    if (unproven := why_not_proven(run, [moving], [met])) is not None:
        return unproven
    off = np.full(len(trajectory.times), meeting.tracking.deviation)
    # Fingers that pass it on both sides keep off it wherever it may be.
    touched = set() if segment.kind in (SegmentKind.PREAPPROACH, SegmentKind.APPROACH) else target
    beside = seen.checker_for(seen_scene, without(others | touched, mode))
    return why_not_swept(as_seen, segment, beside, 0, (-off, off), PARTS)


@lru_cache(maxsize=8)
def _seen_from_belt(context: PlanningContext, conveyor: str) -> PlanningContext:
    """Return the context of the robot as it is seen from a running conveyor."""
    cell = context.cell
    robot = travelling(cell.robot, cell.carriers[conveyor].T_world_carrier[:3, 0], conveyor)
    return PlanningContext(replace(cell, robot=robot), settings=context.settings)


def _with_travel(trajectory: Trajectory, names: tuple[str, ...], travel: Array, speed: float) -> Trajectory:
    """Return a trajectory whose first joint is at (N,) m of travel at m/s."""
    rows = (
        np.column_stack([travel, trajectory.positions]),
        np.column_stack([np.full(len(travel), speed), trajectory.velocities]),
        np.column_stack([np.zeros(len(travel)), trajectory.accelerations]),
    )
    return Trajectory(names, trajectory.times, *rows)
