"""I/O events: what a device must do, and where on the path."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class AnchorKind(StrEnum):
    """How a place on the path is named. Anchors survive stitching; times do not."""

    SEGMENT_START = "segment start"
    SEGMENT_END = "segment end"
    ARC_LENGTH = "arc length"  # offset in m of tool path after (before, if negative) the segment's start
    TIME = "time"  # offset in s after the segment's start


@dataclass(frozen=True)
class Anchor:
    """A place on the path, made where the key waypoints are made."""

    kind: AnchorKind
    segment: int  # index into the plan's segments
    offset: float = 0.0  # m or s by kind; with SEGMENT_START and SEGMENT_END s after (before) it


@dataclass(frozen=True)
class Event:
    """A device action bound to an anchor; ``t_anchor`` and ``t_trigger`` once resolved.

    ``t_trigger = t_anchor - lead``: the effect is complete at the anchor.
    """

    device: str
    action: str
    anchor: Anchor
    lead: float  # s
    t_anchor: float | None = None
    t_trigger: float | None = None
