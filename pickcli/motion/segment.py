"""Segments, the named parts of a motion: on a path, and with their times in a plan."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Self

import numpy as np

from pickcli.cell.tool import ToolState
from pickcli.geometry import Array

MIN_WAY = 1e-6  # joint units of path below which a segment counts as at rest


class SegmentKind(StrEnum):
    """Kinds after Delft (section 2.1); coarse motions are distinguished by whether an item is held."""

    TRANSIT = "transit"  # coarse, empty
    PREAPPROACH = "pre-approach"  # a straight line through the mouth of the place (KTH Fig. 5)
    APPROACH = "approach"  # straight along the tool axis to just before the item
    CONTACT = "contact"  # straight along the tool axis until the cup is pressed on
    LIFT = "lift"  # a straight line off the support
    RETREAT = "retreat"  # straight lines out of the place
    TRANSFER = "transfer"  # coarse, item held
    INSERT = "insert"  # straight into a bin, item held
    PLACE = "place"  # straight down into the tote, or onto the floor of a bin
    PUSH = "push"  # straight and level, empty: against the upper part of an item, which turns over
    DEPART = "depart"  # straight away, empty: from a released item, or from solids that the cup touches


@dataclass(frozen=True)
class SegmentLimits:
    """Speed limits of a segment, and how far its corners may be rounded.

    Attributes:
        speed_scale: Factor on the joints' velocity, acceleration and jerk limits.
        max_tool_speed: m/s of the tip, None if the segment has no limit.
        blend_tolerance: Joint units by which blends may leave the polyline; 0 stops at each corner.
    """

    speed_scale: float = 1.0
    max_tool_speed: float | None = None
    blend_tolerance: float = 0.002


UNLIMITED = SegmentLimits()


@dataclass(frozen=True, eq=False)
class PathSegment:
    """One named part of a path, before it has a time.

    Attributes:
        kind: Kind of the segment.
        waypoints: (N, n) polyline in joint space, N >= 1; the first is the last of the previous segment.
        limits: Speed limits, and how far its corners may be rounded.
    """

    kind: SegmentKind
    waypoints: Array
    limits: SegmentLimits = UNLIMITED

    @property
    def start(self) -> Array:
        """First configuration (n,)."""
        return np.asarray(self.waypoints[0])

    @property
    def end(self) -> Array:
        """Last configuration (n,)."""
        return np.asarray(self.waypoints[-1])

    @property
    def has_length(self) -> bool:
        """Whether the robot moves in this segment."""
        return float(np.abs(np.diff(self.waypoints, axis=0)).sum()) > MIN_WAY

    def scaled(self, by: float) -> Self:
        """Scale all joint limits, in addition to the segment's own scale.

        Args:
            by: Factor on velocity, acceleration and jerk limits.

        Returns:
            The scaled segment.
        """
        return replace(self, limits=replace(self.limits, speed_scale=self.limits.speed_scale * by))


@dataclass(frozen=True)
class Segment:
    """A part of a plan's trajectory with one set of contact rules.

    Attributes:
        kind: Kind of the segment.
        t_start: s.
        t_end: s.
        tool_state: State of the tool.
        held: Id of the item in the cup, or None.
        touching: Names that the tool or the held item may touch here (target, its support, neighbours in the
            first stated distance of the lift, or the last before a release in a bin); everything else keeps
            the cell's clearance.
        pushing: Ids of items in an open box that the held item, or without one the tool's contact link, may
            push here; they may be anywhere in the box afterwards.
    """

    kind: SegmentKind
    t_start: float
    t_end: float
    tool_state: ToolState
    held: str | None
    touching: tuple[str, ...] = ()
    pushing: tuple[str, ...] = ()
