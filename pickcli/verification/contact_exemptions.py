"""Segments in which a plan may touch something, and the states at which the touched solids are at rest."""

from __future__ import annotations

from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.motion.segment import SegmentKind


def releases(plan: Plan) -> tuple[int, ...]:
    """Return the segments at whose end the item is released.

    Args:
        plan: The plan.

    Returns:
        Indices of the segments.
    """
    held = [segment.held is not None for segment in plan.segments]
    return tuple(k for k in range(len(held) - 1) if held[k] and not held[k + 1])


def may_touch(plan: Plan, k: int) -> bool:
    """Whether a segment may have planned contacts at all.

    These are: the contact; the lift after it, or at either end of a recovery motion that continues that lift
    or goes back along it; the place segment that ends with the release, or at either end of a recovery motion
    that continues it or goes back along it; and an empty depart that begins in contact, after a release or at
    the start of a recovery motion.

    Args:
        plan: The plan.
        k: Index of the segment.

    Returns:
        True if it may.
    """
    segment, is_way_out = plan.segments[k], plan.recovery is not None
    is_at_an_end = k in (0, len(plan.segments) - 1)
    if segment.kind is SegmentKind.LIFT:
        return (k > 0 and plan.segments[k - 1].kind is SegmentKind.CONTACT) or (is_way_out and is_at_an_end)
    if segment.kind is SegmentKind.PLACE:
        return k in releases(plan) or (is_way_out and is_at_an_end and segment.held is not None)
    if segment.kind is SegmentKind.DEPART:
        return segment.held is None and ((is_way_out and k == 0) or k - 1 in releases(plan))
    return segment.kind is SegmentKind.CONTACT


def ends_at_rest(plan: Plan, k: int) -> bool:
    """Whether the touched solids are at rest at the end of a segment, and not at its start.

    True if the cup is pressed on or the item is set down, and on the way back along a lift; on the way back
    along a place they are at rest at its start.

    Args:
        plan: The plan.
        k: Index of the segment.

    Returns:
        True if it is.
    """
    segment = plan.segments[k]
    is_way_back = plan.recovery is RecoveryLevel.BACKWARDS
    if is_way_back and len(plan.segments) > 1 and segment.kind is SegmentKind.PLACE:
        return k > 0  # it leads up at the start, and down to the planned release at the end
    return (is_way_back and segment.kind is SegmentKind.LIFT) or segment.kind in (
        SegmentKind.CONTACT,
        SegmentKind.PLACE,
    )
