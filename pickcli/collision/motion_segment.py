"""Segments of motion from their proof to the plan: path, mode and speed limits."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from pickcli.cell.tool import ToolState
from pickcli.collision.allowed_contacts import NO_CONTACTS, AllowedContacts
from pickcli.collision.attached_item import AttachedItem
from pickcli.geometry import Array
from pickcli.motion.segment import PathSegment, Segment, SegmentKind


@dataclass(frozen=True)
class Mode:
    """Mode of a motion: everything except the scene that decides which configurations are valid.

    Source: K. Hauser, J.-C. Latombe, "Multi-modal motion planning in non-expansive spaces" (IJRR 2010).

    Attributes:
        tool_state: State of the tool.
        attached: The attached item, if any.
        contacts: Allowed contacts, and their depth.
        reserve: m, additional to the cell's clearance.
    """

    tool_state: ToolState
    attached: AttachedItem | None = None
    contacts: AllowedContacts = NO_CONTACTS
    reserve: float = 0.0


@dataclass(frozen=True, eq=False)
class MotionSegment(PathSegment):
    """A segment of a path that is proven free in a mode.

    Attributes:
        mode: The mode in which it is proven free.
    """

    mode: Mode = field(kw_only=True)

    def backwards(self, kind: SegmentKind) -> MotionSegment:
        """Reverse the segment; a motion that is free one way is free the other way.

        Args:
            kind: Kind of the segment when it is traversed backwards.

        Returns:
            The reversed segment, in the same mode.
        """
        return replace(self, kind=kind, waypoints=self.waypoints[::-1].copy())

    def unwound(self, by: Array) -> MotionSegment:
        """Shift the segment by whole turns of continuous joints, which gives the same motion.

        Args:
            by: (n,) rad.

        Returns:
            The shifted segment, in the same mode.
        """
        return replace(self, waypoints=self.waypoints + by)

    def timed(self, t_start: float, t_end: float) -> Segment:
        """Return the segment of the plan.

        Args:
            t_start: s in the plan's trajectory.
            t_end: s in the plan's trajectory.

        Returns:
            Its kind and times, the tool's state, the held item and the names that may be touched or pushed.
        """
        attached, contacts = self.mode.attached, self.mode.contacts
        held = attached.id if attached is not None else None
        touching, pushing = tuple(sorted(contacts.names)), tuple(sorted(contacts.pushed))
        return Segment(self.kind, t_start, t_end, self.mode.tool_state, held, touching, pushing)


def at_rest(kind: SegmentKind, q: Array, mode: Mode) -> MotionSegment:
    """Return a segment in which only the tool moves: fingers that close or open, a cup that turns.

    Args:
        kind: Kind of the segment.
        q: (n,) configuration in which the arm rests.
        mode: Mode in which it must be free.

    Returns:
        The segment, without length; the tool determines its duration.
    """
    return MotionSegment(kind, np.stack([q, q]), mode=mode)


def scaled_segments(speed_scale: float, segments: Iterable[MotionSegment]) -> list[MotionSegment]:
    """Return the segments that have a length, at a share of their speed.

    Args:
        speed_scale: Factor on velocity, acceleration and jerk limits.
        segments: Segments of a run.

    Returns:
        Those in which the robot moves.
    """
    return [segment.scaled(speed_scale) for segment in segments if segment.has_length]
