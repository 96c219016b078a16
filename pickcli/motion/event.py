"""I/O events: an action of a device, bound to a place on the path."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class AnchorKind(StrEnum):
    """How a place on the path is stated. Anchors survive stitching; times do not.

    The planner binds its events to ends of segments; plans of other programs may bind theirs by any kind.
    """

    SEGMENT_START = "segment start"
    SEGMENT_END = "segment end"
    ARC_LENGTH = "arc length"  # offset in m of tool path after (before, if negative) the segment's start
    TIME = "time"  # offset in s after the segment's start


@dataclass(frozen=True)
class Anchor:
    """A place on the path, defined together with the key waypoints.

    Attributes:
        kind: How the place is stated.
        segment: Index into the plan's segments.
        offset: m of tool path or s, by kind; for SEGMENT_START and SEGMENT_END, s after (before, if negative)
            it.
    """

    kind: AnchorKind
    segment: int
    offset: float = 0.0


@dataclass(frozen=True)
class Event:
    """A device action bound to an anchor.

    ``t_trigger = t_anchor - lead``: the effect is complete at the anchor.

    Attributes:
        device: Name of a device of the cell.
        action: One of its actions.
        anchor: Place on the path at which the effect is complete.
        lead: s from the command to its full effect.
        t_anchor: s, once resolved.
        t_trigger: s, once resolved.
    """

    device: str
    action: str
    anchor: Anchor
    lead: float
    t_anchor: float | None = None
    t_trigger: float | None = None
