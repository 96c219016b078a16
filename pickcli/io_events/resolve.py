"""Resolution of anchors to times of a timed motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.event import Anchor, AnchorKind, Event
from pickcli.motion.segment import Segment
from pickcli.motion.trajectory import Trajectory

Travel: TypeAlias = "Array | Callable[[Array], Array]"
"""m of tool path since the start, never decreasing: at the trajectory's times (N,), or a function of time."""

TIME_ROUNDING = 1e-9  # s by which equal times may differ


@dataclass(frozen=True)
class ResolvedEvents:
    """Events with their times.

    Attributes:
        events: The given events in their order, with ``t_anchor`` and ``t_trigger``.
        start_delay: s by which the motion must be delayed to meet every lead. If it is above 0, some
            ``t_trigger`` are negative, and no trigger has been moved: wait that long at the start, shift the
            segments, and resolve again.
        reasons: Events whose place is not on this path; empty if all are.
    """

    events: tuple[Event, ...]
    start_delay: float
    reasons: tuple[Reason, ...] = ()


def resolve(
    events: Sequence[Event], segments: Sequence[Segment], trajectory: Trajectory, travel: Travel | None = None
) -> ResolvedEvents:
    """Compute the time of every event's anchor, and its trigger, which precedes it by the device's lead.

    Args:
        events: Events bound to anchors.
        segments: Segments of the trajectory.
        trajectory: The timed motion.
        travel: Tool travel in m along the trajectory, needed only for anchors by arc length.

    Returns:
        The events with their times.

    Raises:
        ValueError: If an anchor by arc length has no ``travel``.
    """
    resolved, reasons = [], []
    for event in events:
        t_anchor = anchor_time(event.anchor, segments, trajectory, travel)
        if t_anchor is None:
            where = f"{event.device} {event.action}"
            detail = f"{event.anchor.offset:.4f} m after segment {event.anchor.segment} is not on the path"
            reasons.append(Reason("anchor off the path", where, detail))
            t_anchor = segments[event.anchor.segment].t_start
        resolved.append(replace(event, t_anchor=t_anchor, t_trigger=t_anchor - event.lead))
    earliest = min((e.t_trigger for e in resolved if e.t_trigger is not None), default=0.0)
    return ResolvedEvents(tuple(resolved), -earliest if earliest < -TIME_ROUNDING else 0.0, tuple(reasons))


def delay_segments(segments: Sequence[Segment], delay: float) -> tuple[Segment, ...]:
    """Shift the segments of a motion that waits first; the wait belongs to the first segment.

    Args:
        segments: Segments of the motion, with their times.
        delay: s.

    Returns:
        The shifted segments.
    """
    return tuple(
        replace(
            segment,
            t_start=segment.t_start + delay if index else segment.t_start,
            t_end=segment.t_end + delay,
        )
        for index, segment in enumerate(segments)
    )


def anchor_time(
    anchor: Anchor, segments: Sequence[Segment], trajectory: Trajectory, travel: Travel | None = None
) -> float | None:
    """Return the time at which the place of an anchor is passed.

    Args:
        anchor: A place on the path.
        segments: Segments of the trajectory.
        trajectory: The timed motion.
        travel: Tool travel in m along the trajectory, needed only for anchors by arc length.

    Returns:
        s, or None if an arc length is not on the path.

    Raises:
        ValueError: If an anchor by arc length has no ``travel``.
    """
    segment = segments[anchor.segment]
    if anchor.kind is AnchorKind.SEGMENT_END:
        return segment.t_end + anchor.offset
    if anchor.kind is not AnchorKind.ARC_LENGTH:
        return segment.t_start + anchor.offset
    if travel is None:
        raise ValueError("an anchor by arc length needs the tool's travel along the trajectory")
    return _time_of_travel(segment.t_start, anchor.offset, trajectory, travel)


def _time_of_travel(start: float, offset: float, trajectory: Trajectory, travel: Travel) -> float | None:
    """Return the first time at which the tool is ``offset`` m of its path beyond its place at ``start``."""
    times = trajectory.times
    along = travel(times) if callable(travel) else travel
    at_start = travel(np.array([start]))[0] if callable(travel) else np.interp(start, times, along)
    wanted = float(at_start) + offset
    if not along[0] - TIME_ROUNDING <= wanted <= along[-1] + TIME_ROUNDING:
        return None
    i = int(np.clip(np.searchsorted(along, wanted, side="left"), 1, len(times) - 1))
    gained = along[i] - along[i - 1]
    share = (wanted - along[i - 1]) / gained if gained > 0.0 else 0.0
    return float(times[i - 1] + np.clip(share, 0.0, 1.0) * (times[i] - times[i - 1]))
