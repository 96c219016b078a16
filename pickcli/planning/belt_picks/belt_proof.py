"""What every pick from a running conveyor must keep: its events in time, and free ways at every instant.

Before the tool works on the belt and after that, every segment is proven in the scene in which it was
planned, with all that what rides on the belt may come to. While it does, that depends on what follows the
belt.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pickcli.collision.motion_segment import Mode, MotionSegment
from pickcli.errors import Failures, Reason
from pickcli.io_events.event_binding import BoundEvents, bound_events
from pickcli.motion.plan import times_at_work
from pickcli.motion.segment import Segment
from pickcli.motion.trajectory import SAME_TIME, Trajectory
from pickcli.planning.assembly.timed_motion_validation import why_not_proven
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import Scene
from pickcli.timing.concatenation import RestingRun
from pickcli.timing.plan_parts import PlanPart


@dataclass(frozen=True, eq=False)
class SceneSegment:
    """A segment that is to be proven.

    Attributes:
        scene: Scene in which it was planned.
        segment: The segment.
    """

    scene: Scene
    segment: MotionSegment


WhyNotFree = Callable[[SceneSegment, Segment], Reason | None]


def bound_in_time(
    context: PlanningContext, segments: Sequence[Segment], trajectory: Trajectory
) -> BoundEvents | Failures | float:
    """Bind the events of a pick whose meeting with its item is fixed in time.

    Args:
        context: The cell with its devices, and the settings.
        segments: The segments of the plan.
        trajectory: Its motion.

    Returns:
        Segments, motion and events; every reason against them; or the s by which the meeting has to be later,
        for a device that needs the time.
    """
    rests = context.method.rests(context.cell.devices, context.settings.release_time)
    scheduled = bound_events(context.cell, segments, trajectory, rests.taking, rests.releasing)
    if isinstance(scheduled, Failures):
        return scheduled
    missing = scheduled[1].duration - trajectory.duration
    return missing if missing > SAME_TIME else scheduled


def why_not_free(
    context: PlanningContext, proofs: Sequence[SceneSegment], trajectory: Trajectory,
    segments: Sequence[Segment], at_work: WhyNotFree,
) -> Reason | None:  # fmt: skip
    """Explain why a motion is not proven free of the hall, or of what rides on the belt at every instant.

    Args:
        context: The cell, with its checkers.
        proofs: What is to be proven, one for each segment.
        trajectory: The motion in the hall.
        segments: The segments of the plan.
        at_work: Explains the same of a segment in which the tool works on the belt.

    Returns:
        The first reason; None if it is proven.
    """
    t_works, t_left = times_at_work(segments)
    for proof, segment in zip(proofs, segments, strict=True):
        if t_works <= segment.t_start < t_left:
            unproven = at_work(proof, segment)
        else:
            checker = context.checker_for(proof.scene, proof.segment.mode)
            unproven = why_not_proven(run_of(trajectory, segment), [proof.segment], [checker])
        if unproven is not None:
            return unproven
    return None


def run_of(trajectory: Trajectory, segment: Segment) -> RestingRun:
    """Return the run of one segment.

    Args:
        trajectory: The motion of the plan.
        segment: One of its segments.

    Returns:
        The run, in the time of the plan.
    """
    return RestingRun(trajectory, np.array([segment.t_start, segment.t_end]), np.ones(1))


def segments_of(parts: Sequence[PlanPart]) -> list[MotionSegment]:
    """Return the segments of parts, one for each segment of the plan.

    Args:
        parts: Parts of a plan, in their order.

    Returns:
        Their segments, without time.
    """
    found: list[MotionSegment] = []
    continues = False
    for part in parts:
        found += list(part.segments)[1 if continues else 0 :]
        found += [] if part.at_rest is None else [part.at_rest]
        continues = part.continues
    return found


def without(absent: set[str], mode: Mode) -> Mode:
    """Return a mode in which some bodies and items of the world are absent.

    Args:
        absent: Their names.
        mode: The mode.

    Returns:
        The mode without them.
    """
    return replace(mode, contacts=replace(mode.contacts, absent=mode.contacts.absent | absent))
