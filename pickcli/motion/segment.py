"""Segments: the named parts of a motion."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from pickcli.cell.tool import ToolState


class SegmentKind(StrEnum):
    """Kinds after Delft (section 2.1); coarse motions are split by whether something is held."""

    TRANSIT = "transit"  # coarse, empty
    PREAPPROACH = "pre-approach"  # straight along the bin's axis into the bin (KTH Fig. 5)
    APPROACH = "approach"  # straight along the tool axis to just before the item
    CONTACT = "contact"  # straight along the tool axis until the cup is pressed on
    LIFT = "lift"  # straight up
    RETREAT = "retreat"  # straight out of the bin
    TRANSFER = "transfer"  # coarse, item held
    INSERT = "insert"  # straight into a bin, item held
    PLACE = "place"  # straight down into the tote, or onto the floor of a bin
    DEPART = "depart"  # straight away, empty: from where the item was let go, or from what the cup touches


@dataclass(frozen=True)
class Segment:
    """A part [t_start, t_end] of the plan's trajectory.

    held: id of the item in the cup, or None
    touching: names that the tool or the held item may touch here (target, its support, neighbours in
    the first stated distance of the lift, or the last before it is let go in a bin); everything else is
    clear by the cell's clearance
    """

    kind: SegmentKind
    t_start: float  # s
    t_end: float  # s
    tool_state: ToolState
    held: str | None
    touching: tuple[str, ...] = ()
