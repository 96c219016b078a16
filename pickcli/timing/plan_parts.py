"""Parts of a plan between two stops, and the plan's trajectory with its segments, joined from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from pickcli.collision.motion_segment import MotionSegment
from pickcli.motion.segment import Segment
from pickcli.motion.trajectory import Trajectory
from pickcli.timing.concatenation import Run, concatenate


@dataclass(frozen=True, eq=False)
class PlanPart:
    """A run with its segments, and the rest of the arm after it.

    Attributes:
        segments: Segments of the run.
        run: The run.
        rest: s at rest after it.
        at_rest: The segment of that rest, in which only the tool moves; None if the rest belongs to the last
            segment of the run.
        continues: Whether the last segment continues with the first one of the next part.
    """

    segments: Sequence[MotionSegment]
    run: Run
    rest: float = 0.0
    at_rest: MotionSegment | None = None
    continues: bool = False


def joined(parts: Sequence[PlanPart]) -> tuple[Trajectory, tuple[Segment, ...]]:
    """Join parts, each starting where the one before it ends, to one trajectory with its segments.

    Args:
        parts: The parts of a plan, in their order.

    Returns:
        The trajectory, and its segments with their times.
    """
    whole = concatenate([part.run for part in parts], [part.rest for part in parts[:-1]])
    ends = [*whole.starts[1:], whole.trajectory.duration]
    segments: list[Segment] = []
    continues = False
    for part, t_start, t_end in zip(parts, whole.starts, ends, strict=True):
        timed = _timed(part, float(t_start), float(t_end))
        if continues:
            segments[-1] = replace(segments[-1], t_end=timed.pop(0).t_end)
        segments += timed
        continues = part.continues
    return whole.trajectory, tuple(segments)


def _timed(part: PlanPart, t_start: float, t_end: float) -> list[Segment]:
    """Return the segments of a part of a plan that lasts, with its rest, between two times."""
    t_rest = t_end if part.at_rest is None else t_end - part.rest
    ends = [t_start, *(t_start + part.run.part_times[1:-1]).tolist(), t_rest]
    timed = [s.timed(*span) for s, span in zip(part.segments, pairwise(ends), strict=True)]
    return timed if part.at_rest is None else [*timed, part.at_rest.timed(t_rest, t_end)]
