"""What a plan lets the robot touch at one moment: one value, from the segments that it may be in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from pickcli.cell.tool import MOVING, Tool
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind

NONE: frozenset[str] = frozenset()


@dataclass(frozen=True)
class PlannedContacts:
    """What may be touched now, by name.

    Attributes:
        touching: What the held item may touch, and what a cup may.
        met: What the links of the tool that meet items may press on: a cup, or the fingers.
        held: What is held by the plan, whether it really is or not.
        is_meeting: Whether the tool takes an item or lets it go, which still stands where it stood.
    """

    touching: frozenset[str] = NONE
    met: frozenset[str] = NONE
    held: frozenset[str] = NONE
    is_meeting: bool = False

    @classmethod
    def of(cls, plan: Plan, now: Sequence[Segment], tool: Tool) -> PlannedContacts:
        """The contacts of a plan in some of its segments.

        Args:
            plan: The plan.
            now: Those of its segments that the robot may be in.
            tool: The tool.

        Returns:
            What any of them allows.
        """
        touching = frozenset(name for segment in now for name in segment.touching)
        held = frozenset(segment.held for segment in now if segment.held is not None)
        is_contact = any(segment.kind is SegmentKind.CONTACT for segment in now)
        if not tool.grip.takes_widths:
            return cls(touching, touching | held, held, is_contact)
        met = frozenset(name for segment in now for name in _met_by_fingers(plan, segment))
        return cls(touching, met, held, is_contact or any(s.tool_state == MOVING for s in now))

    def also(self, names: frozenset[str]) -> PlannedContacts:
        """Allow more contacts.

        Args:
            names: What held item and tool may touch as well.

        Returns:
            The contacts.
        """
        return replace(self, touching=self.touching | names, met=self.met | names)


def _met_by_fingers(plan: Plan, segment: Segment) -> tuple[str, ...]:
    """What fingers may touch: what they close on, and what they have let go of and may lean on them."""
    if segment.kind is SegmentKind.DEPART and plan.grasp is not None:
        return (plan.grasp.item,)
    return segment.touching if segment.tool_state == MOVING else ()
