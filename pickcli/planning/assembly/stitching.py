"""Stitching of lines and coarse motions into one timed, proven plan with its events.

Delft, section 3: the segments are stitched into one motion plan, timed as a whole, and the events follow the
key waypoints. The motion stops only to grasp and to release, and where the tool changes its state with the
item.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pickcli.cell.device import device_of
from pickcli.collision.motion_segment import MotionSegment, at_rest, scaled_segments
from pickcli.errors import Failures, Reason
from pickcli.io_events.bind import bind_tool_states
from pickcli.io_events.event_binding import bound_events
from pickcli.io_events.resolve import resolve
from pickcli.motion.plan import Plan
from pickcli.planning.assembly.carried_motion import carried_motion
from pickcli.planning.assembly.pick_plan import pick_plan
from pickcli.planning.assembly.proven_timing import proven_run
from pickcli.planning.pick_motion import PickMotion
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import Scene
from pickcli.scene.scene_file import scene_hash
from pickcli.timing.concatenation import RestingRun
from pickcli.timing.plan_parts import PlanPart, joined

SETTLING = 0.05  # s at rest in the new state of the tool, at the end of a motion that ends with the change


@dataclass(frozen=True, eq=False)
class ToolChange:
    """A motion of the empty tool with a change of its state; each segment may have no length.

    Attributes:
        before: In the state at the start.
        changing: While the tool may be in any state.
        after: In the new state.
    """

    before: MotionSegment
    changing: MotionSegment
    after: MotionSegment


def stitch_pick(problem: PickProblem, motion: PickMotion) -> Plan | Failures:
    """Time and prove a pick, and bind its events.

    Args:
        problem: The pick.
        motion: Its segments, not yet timed.

    Returns:
        The plan, uncertified; or every reason, if the cup cannot hold at any speed or a proof fails.
    """
    context, scene = problem.context, problem.scene
    to_item = scaled_segments(context.cell.speed_scale, [motion.transit, *motion.taking.inward])
    first = proven_run(context, scene, to_item)
    if isinstance(first, Failures):
        return first
    carried = carried_motion(problem, motion)
    if isinstance(carried, Failures):
        return carried
    rests = context.method.rests(context.cell.devices, context.settings.release_time)
    closing = motion.taking.inward[-1] if context.method.closes_at_rest else None
    trajectory, segments = joined([
        PlanPart(to_item, first, rests.taking, closing),
        *carried.parts,
        *carried.away,
    ])  # fmt: skip
    scheduled = bound_events(context.cell, segments, trajectory, rests.taking, rests.releasing)
    if isinstance(scheduled, Failures):
        return scheduled
    return pick_plan(problem, scene, scheduled, carried.load.of(motion.taking.grasp))


def stitch_run(
    context: PlanningContext, scene: Scene, segments: Sequence[MotionSegment], label: str, seed: int
) -> Plan | Failures:
    """Time and prove one run of the empty tool, as a plan.

    Args:
        context: The cell with the models that time and prove the run.
        scene: The planning scene.
        segments: Segments of the run, from rest to rest.
        label: Name of the plan.
        seed: Seed recorded in the plan.

    Returns:
        The plan, uncertified; or every reason, if start and goal coincide or a proof fails.
    """
    return stitch_runs(context, scene, [segments], label, seed)


def stitch_runs(
    context: PlanningContext, scene: Scene, runs: Sequence[Sequence[MotionSegment]], label: str, seed: int,
    rest: float = 0.0,
) -> Plan | Failures:  # fmt: skip
    """Time and prove runs of the empty tool, one after the other, as a plan.

    Args:
        context: The cell with the models that time and prove the runs.
        scene: The planning scene.
        runs: Segments of each run, from rest to rest.
        label: Name of the plan.
        seed: Seed recorded in the plan.
        rest: s at rest between two runs.

    Returns:
        The plan, uncertified; or every reason, if start and goal coincide or a proof fails.
    """
    parts: list[PlanPart] = []
    for segments in filter(None, (scaled_segments(context.cell.speed_scale, run) for run in runs)):
        run = proven_run(context, scene, segments)
        if isinstance(run, Failures):
            return run
        parts.append(PlanPart(segments, run, rest))
    if not parts:
        return Failures.of(Reason("nothing to do", "", "start and goal are the same"))
    return _empty_plan(context, scene, parts, label, seed)


def stitch_tool_change(
    context: PlanningContext, scene: Scene, change: ToolChange, label: str, seed: int
) -> Plan | Failures:
    """Time and prove a motion of the empty tool with a change of its state, as a plan with that event.

    The segment of the change lasts at least the lead of the tool's actuator; the arm rests for what the
    motion leaves of that. If the arm is at the goal then, it rests for ``SETTLING``, so that the plan ends
    with a segment that states the new state.

    Args:
        context: The cell with the models that time and prove the motion.
        scene: The planning scene.
        change: The motion, from rest to rest.
        label: Name of the plan.
        seed: Seed recorded in the plan.

    Returns:
        The plan, uncertified; or every reason, if a proof fails.
    """
    lead = device_of(context.cell.devices, context.cell.robot.tool.mover).lead
    parts: list[PlanPart] = []
    for segment, least in ((change.before, 0.0), (change.changing, lead), (change.after, SETTLING)):
        moving, duration = scaled_segments(context.cell.speed_scale, [segment]), 0.0
        if moving:
            run = proven_run(context, scene, moving)
            if isinstance(run, Failures):
                return run
            duration = run.trajectory.duration
            parts.append(PlanPart(moving, run, continues=duration < least))
        if duration < least:
            standing = at_rest(segment.kind, segment.end, segment.mode)
            names = context.cell.robot.joint_names
            parts.append(PlanPart([standing], RestingRun.of(names, segment.end, least - duration)))
    return _empty_plan(context, scene, parts, label, seed)


def _empty_plan(
    context: PlanningContext, scene: Scene, parts: Sequence[PlanPart], label: str, seed: int
) -> Plan:
    """Return the plan of runs of the empty tool, with the events that change the tool's state."""
    trajectory, segments = joined(parts)
    cell = context.cell
    events = bind_tool_states(segments, cell.devices, cell.robot.tool)
    resolved = resolve(events, segments, trajectory).events
    return Plan(
        label, cell.fingerprint, scene_hash(scene), seed, segments, trajectory, resolved,
        arm=cell.arm, others=cell.others,
    )  # fmt: skip
