"""Proof that a timed motion is free at every instant, not only the path that was timed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pickcli.collision.checker import SceneChecker
from pickcli.collision.motion_segment import MotionSegment
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.segment import Segment
from pickcli.motion.trajectory import Trajectory
from pickcli.timing.concatenation import Run
from pickcli.timing.trajectory_chords import swept_chords, trajectory_chords
from pickcli.timing.trajectory_sampling import divided


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
    times = run.trajectory.times
    spans = zip(run.part_times[:-1], run.part_times[1:], strict=True)
    for segment, checker, (t_start, t_end) in zip(segments, checkers, spans, strict=True):
        first = max(0, int(np.searchsorted(times, t_start, side="right")) - 1)
        last = min(len(times) - 1, int(np.searchsorted(times, t_end, side="left")))
        if last <= first:
            continue
        chords, slack = trajectory_chords(_piece(run.trajectory, first, last))
        i = checker.first_blocked_edge(chords, slack)
        if i >= 0:
            reason = checker.explain_path(chords[i : i + 2], slack[i : i + 1])
            where = f"{segment.kind} at {times[first + i]:.3f} s"
            what = "the timed motion is not proven free"
            return Reason(what, where, str(reason), reason.in_the_way)
    return None


def why_not_swept(
    trajectory: Trajectory, segment: Segment, checker: SceneChecker, axis: int, shifts: tuple[Array, Array],
    parts: int = 1,
) -> Reason | None:  # fmt: skip
    """Explain why a segment is not proven free wherever its motion is displaced along an axis.

    Args:
        trajectory: The motion, N points.
        segment: The segment.
        checker: Its checker.
        axis: Index of the axis.
        shifts: (N,) least and (N,) greatest displacement along it at the points.
        parts: Number of parts of each quintic that are proven one by one: the joints' motion within one
            counts as slack, although motions of several joints may cancel out.

    Returns:
        The reason for the first quintic that is not proven free; None if all are.
    """
    t = trajectory.times
    first = max(0, int(np.searchsorted(t, segment.t_start, side="right")) - 1)
    last = min(len(t) - 1, int(np.searchsorted(t, segment.t_end, side="left")))
    if last <= first:
        return None
    low, high = (shift[first : last + 1] for shift in shifts)
    least, most = (np.repeat(each, parts) for each in _bounds(low, high))
    edges, slack = swept_chords(divided(_piece(trajectory, first, last), parts), axis, least, most)
    i = checker.first_blocked_edge(edges, slack)
    if i < 0:
        return None
    reason = checker.explain_path(edges[i : i + 2], slack[i : i + 1])
    where = f"{segment.kind} at {t[first + i // (2 * parts)]:.3f} s"
    return Reason("the timed motion is not proven free", where, str(reason), reason.in_the_way)


def _piece(trajectory: Trajectory, first: int, last: int) -> Trajectory:
    """Return the motion from one of its points to another."""
    at = slice(first, last + 1)
    rows = (trajectory.positions, trajectory.velocities, trajectory.accelerations)
    return Trajectory(trajectory.joint_names, trajectory.times[at], *(row[at] for row in rows))


def _bounds(low: Array, high: Array) -> tuple[Array, Array]:
    """Return the least and the greatest displacement (N - 1,) on the pieces between N points."""
    return np.minimum(low[:-1], low[1:]), np.maximum(high[:-1], high[1:])
