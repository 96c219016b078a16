"""Contacts that a plan allows at one moment, from the segments that the robot may be in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from pickcli.cell.tool import MOVING, Tool
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind

NONE: frozenset[str] = frozenset()


@dataclass(frozen=True)
class PlannedContacts:
    """Names of the bodies that may be touched at present.

    Attributes:
        touching: Bodies that the held item may touch or push aside; a suction cup may touch them, too.
        met: Bodies that the contact links, cup or fingers, may press on.
        held: Items held according to the plan, whether they really are or not.
        is_meeting: Whether the tool is taking or releasing an item, which is still at its place.
    """

    touching: frozenset[str] = NONE
    met: frozenset[str] = NONE
    held: frozenset[str] = NONE
    is_meeting: bool = False

    @classmethod
    def of(cls, plan: Plan, now: Sequence[Segment], tool: Tool) -> PlannedContacts:
        """Combine the contacts of some segments of a plan.

        Args:
            plan: The plan.
            now: The segments that the robot may be in.
            tool: The tool.

        Returns:
            Everything that any of them allows.
        """
        pushed = frozenset(name for segment in now for name in segment.pushing)
        touching = pushed | {name for segment in now for name in segment.touching}
        held = frozenset(segment.held for segment in now if segment.held is not None)
        is_contact = any(segment.kind is SegmentKind.CONTACT for segment in now)
        if not tool.grip.takes_widths:
            return cls(touching, touching | held, held, is_contact)
        met = pushed | {name for segment in now for name in _met_by_fingers(plan, segment)}
        return cls(touching, met, held, is_contact or any(s.tool_state == MOVING for s in now))

    def also(self, names: frozenset[str]) -> PlannedContacts:
        """Allow more contacts.

        Args:
            names: Further bodies that the held item and the tool may touch.

        Returns:
            The extended contacts.
        """
        return replace(self, touching=self.touching | names, met=self.met | names)


def _met_by_fingers(plan: Plan, segment: Segment) -> tuple[str, ...]:
    """Items that fingers may touch: those they close on, and a released one that may lean on them."""
    if segment.kind is SegmentKind.DEPART and plan.grasp is not None:
        return (plan.grasp.item,)
    return segment.touching if segment.tool_state == MOVING else ()
