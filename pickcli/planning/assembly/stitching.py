"""Stitching of lines and coarse motions into one timed, proven plan with its events.

Delft, section 3: the segments are stitched into one motion plan, timed as a whole, and the events follow the
key waypoints. The motion stops only to grasp and to release, and where the tool turns with the item.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.device import device_of
from pickcli.cell.tool import MOVING
from pickcli.collision.motion_segment import MotionSegment
from pickcli.errors import Failures, Reason
from pickcli.grasping.grasp_method import GraspTimes
from pickcli.grasping.holding import GripLoad
from pickcli.kinematics.tool_turn import turning_tip
from pickcli.motion.plan import Grasp, Plan
from pickcli.motion.segment import Segment
from pickcli.motion.trajectory import Trajectory
from pickcli.planning.assembly.events import Schedule, schedule
from pickcli.planning.assembly.proven_timing import CarriedRun, carried_runs, proven_run
from pickcli.planning.assembly.tool_path_check import thrown
from pickcli.planning.pick_motion import PickMotion
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import Scene
from pickcli.scene.scene_file import scene_hash
from pickcli.timing.concatenation import concatenate
from pickcli.timing.timed_run import TimedRun


def stitch_pick(problem: PickProblem, motion: PickMotion) -> Plan | Failures:
    """Time and prove a pick, and bind its events.

    Args:
        problem: The pick.
        motion: Its segments, not yet timed.

    Returns:
        The plan, uncertified; or every reason, if the cup cannot hold at any speed or a proof fails.
    """
    context, scene = problem.context, problem.scene
    to_item = _moving(context, [motion.transit, *motion.taking.inward])
    away = _moving(context, motion.placement.away)
    first = proven_run(context, scene, to_item)
    if isinstance(first, Failures):
        return first
    carried = _carried(problem, motion)
    if isinstance(carried, Failures):
        return carried
    last = proven_run(context, motion.placement.scene, away)
    if isinstance(last, Failures):
        return last
    rests = context.method.rests(context.cell.devices, context.settings.release_time)
    runs = [first, *(part.run for part in carried.runs), last]
    resting = [rests.taking, *carried.rests, rests.releasing]
    trajectory, segments = _joined([*to_item, *carried.segments, *away], runs, resting)
    segments = carried.with_turn(segments, len(to_item))
    if context.method.closes_at_rest:
        segments = _with_rests(segments, rests, motion)
    scheduled = schedule(context, segments, trajectory, rests)
    if isinstance(scheduled, Failures):
        return scheduled
    plan = _plan(problem, scheduled, carried.load.of(motion.taking.grasp))
    too_fast = thrown(context.arm, plan, context.cell.devices)
    return plan if too_fast is None else Failures.of(too_fast)


@dataclass(frozen=True, eq=False)
class _Carried:
    """The timed motion with the item.

    Attributes:
        runs: Its runs; the first two are one segment if the weight is taken up slowly.
        segments: The segments of all runs, one after the other.
        rests: s at rest after each run but the last.
        n_before_turn: Number of segments before the turn of the tool, the lift counted once.
        turn: The segment in which the tool turns, at rest; None without one.
        load: The worst load on the cup, also during the turn.
    """

    runs: tuple[CarriedRun, ...]
    segments: tuple[MotionSegment, ...]
    rests: tuple[float, ...]
    n_before_turn: int
    turn: MotionSegment | None
    load: GripLoad

    def with_turn(self, segments: tuple[Segment, ...], n_before: int) -> tuple[Segment, ...]:
        """Merge the two runs of a lift in timed segments, and split off the turn.

        Args:
            segments: The timed segments of the plan.
            n_before: Number of them before the item is held.

        Returns:
            The segments of the plan.
        """
        n_merged = len(self.runs) - (1 if self.turn is None else 2)
        if n_merged:
            segments = _joined_at(segments, n_before)
        if self.turn is None:
            return segments
        k = n_before + self.n_before_turn - 1
        return (*segments[:k], *_cut(segments[k], self.rests[-1], self.turn), *segments[k + 1 :])


def _carried(problem: PickProblem, motion: PickMotion) -> _Carried | Failures:
    """Time the motion with the item, in one part, or in two between which the tool turns."""
    context, item, taking = problem.context, problem.target.item, motion.taking
    before, turn, after = _parted([*taking.outward, *motion.transfer.segments, *motion.placement.inward])
    parts = [
        [segment.scaled(item.speed_scale) for segment in _moving(context, part)]
        for part in (before, after)
        if part
    ]
    hold = context.method.hold(item, taking.grasp.face, taking.attached.T_tip_item)
    runs = carried_runs(context, problem.scene, parts, taking.grasp, hold)
    if isinstance(runs, Failures):
        return runs
    loads, lift = [run.load for run in runs], parts[0][:1]
    rests = [0.0] * (len(runs) - len(parts))
    if turn is not None:
        duration = device_of(context.cell.devices, context.cell.robot.tool.mover).lead
        states = before[-1].mode.tool_state, after[0].mode.tool_state
        loads.append(hold.in_motion(turning_tip(context.arm, turn.start, *states, duration)))
        rests.append(duration)
    segments = (*lift * len(rests[: len(runs) - len(parts)]), *(s for part in parts for s in part))
    return _Carried(runs, segments, tuple(rests), len(parts[0]), turn, GripLoad.worst(loads))


def _parted(
    segments: Sequence[MotionSegment],
) -> tuple[Sequence[MotionSegment], MotionSegment | None, Sequence[MotionSegment]]:
    """Return the segments before the turn of the tool, the turn, and those after it."""
    k = next((k for k, s in enumerate(segments) if s.mode.tool_state == MOVING), len(segments))
    return segments[:k], segments[k] if k < len(segments) else None, segments[k + 1 :]


def _plan(problem: PickProblem, scheduled: Schedule, grasp: Grasp) -> Plan:
    segments, trajectory, events = scheduled
    cell = problem.context.cell
    return Plan(
        query=problem.label,
        cell_fingerprint=cell.fingerprint,
        scene_hash=scene_hash(problem.scene),
        seed=problem.seed,
        segments=segments,
        trajectory=trajectory,
        events=events,
        grasp=grasp,
        speed_scale=problem.target.item.speed_scale,
        arm=cell.arm,
        others=cell.others,
    )


def stitch_run(
    context: PlanningContext, scene: Scene, segments: Sequence[MotionSegment], label: str, seed: int
) -> Plan | Failures:
    """Time and prove one run of the empty tool, as a plan without events.

    Args:
        context: The cell with the models that time and prove the run.
        scene: The planning scene.
        segments: Segments of the run, from rest to rest.
        label: Name of the plan.
        seed: Seed recorded in the plan.

    Returns:
        The plan, uncertified; or every reason, if start and goal coincide or a proof fails.
    """
    segments = _moving(context, segments)
    if not segments:
        return Failures.of(Reason("nothing to do", "", "start and goal are the same"))
    run = proven_run(context, scene, segments)
    if isinstance(run, Failures):
        return run
    trajectory, timed = _joined(segments, [run], [])
    cell = context.cell
    return Plan(
        label, cell.fingerprint, scene_hash(scene), seed, timed, trajectory, (),
        arm=cell.arm, others=cell.others,
    )  # fmt: skip


def _with_rests(segments: tuple[Segment, ...], rests: GraspTimes, motion: PickMotion) -> tuple[Segment, ...]:
    """Split off the rests in which only the fingers move as segments.

    Args:
        segments: Segments that move; the arm rests at the end of the last one before the item is held, and of
            the last one that holds it.
        rests: Durations of these rests.
        motion: The pick of a tool that closes at rest: its way in ends with the segment in which the fingers
            close, its way away begins with the one in which they open.
    """
    closing, opening = motion.taking.inward[-1], motion.placement.away[0]
    held = [k for k, segment in enumerate(segments) if segment.held is not None]
    taken, let_go = held[0] - 1, held[-1]
    return (
        *segments[:taken],
        *_cut(segments[taken], rests.taking, closing),
        *segments[held[0] : let_go],
        *_cut(segments[let_go], rests.releasing, opening),
        *segments[let_go + 1 :],
    )


def _cut(segment: Segment, rest: float, at_rest: MotionSegment) -> tuple[Segment, Segment]:
    """Split a segment before its last seconds; these become a segment at rest."""
    t = segment.t_end - rest
    return replace(segment, t_end=t), at_rest.timed(t, segment.t_end)


def _moving(context: PlanningContext, segments: Iterable[MotionSegment]) -> list[MotionSegment]:
    """Return the segments that have a length, at the cell's speed."""
    return [segment.scaled(context.cell.speed_scale) for segment in segments if segment.has_length]


def _joined(
    segments: Sequence[MotionSegment], runs: Sequence[TimedRun], rests: Sequence[float]
) -> tuple[Trajectory, tuple[Segment, ...]]:
    """Join all runs to one trajectory with its segments; a rest after a run belongs to its last segment."""
    joined = concatenate(runs, rests)
    starts = np.concatenate([run.part_times[:-1] + t for run, t in zip(runs, joined.starts, strict=True)])
    starts[0] = 0.0
    ends = np.append(starts[1:], joined.trajectory.duration)
    timed = (s.timed(float(t0), float(t1)) for s, t0, t1 in zip(segments, starts, ends, strict=True))
    return joined.trajectory, tuple(timed)


def _joined_at(segments: tuple[Segment, ...], k: int) -> tuple[Segment, ...]:
    """Merge the segment with index k and the next one."""
    return (*segments[:k], replace(segments[k], t_end=segments[k + 1].t_end), *segments[k + 2 :])
