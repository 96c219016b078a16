"""Proof that a timed motion is free at every instant, not only the path that was timed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pickcli.collision.checker import SceneChecker
from pickcli.collision.motion_segment import MotionSegment
from pickcli.errors import Reason
from pickcli.timing.concatenation import Run
from pickcli.timing.trajectory_chords import trajectory_chords


def why_not_proven(
    run: Run, segments: Sequence[MotionSegment], checkers: Sequence[SceneChecker]
) -> Reason | None:
    """Explain why a timed motion is not proven free; each quintic is proven by the checker of its segment.

    A quintic that extends into two segments is proven by both checkers.

    Args:
        run: The timed run.
        segments: Segments of the run, one for each of its parts.
        checkers: Checker of each segment.

    Returns:
        The reason for the first quintic that is not proven free; None if all are.
    """
    chords, slack = trajectory_chords(run.trajectory)
    times = run.trajectory.times
    spans = zip(run.part_times[:-1], run.part_times[1:], strict=True)
    for segment, checker, (t_start, t_end) in zip(segments, checkers, spans, strict=True):
        first = max(0, int(np.searchsorted(times, t_start, side="right")) - 1)
        last = min(len(times) - 1, int(np.searchsorted(times, t_end, side="left")))
        if last <= first:
            continue
        i = checker.first_blocked_edge(chords[first : last + 1], slack[first:last])
        if i >= 0:
            k = first + i
            reason = checker.explain_path(chords[k : k + 2], slack[k : k + 1])
            where = f"{segment.kind} at {times[k]:.3f} s"
            what = "the timed motion is not proven free"
            return Reason(what, where, str(reason), reason.in_the_way)
    return None
