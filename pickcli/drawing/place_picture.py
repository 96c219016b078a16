"""Picture of a cell's reachability: tested tool poses, and a bar for every place."""

from __future__ import annotations

from collections.abc import Sequence

from pickcli.cell.cell import Cell
from pickcli.drawing.picture import Colour, Coverage, CoverageBar, DrawnNode, Picture
from pickcli.drawing.scenery import arm_solids, skeleton, solids
from pickcli.kinematics.arm import Arm
from pickcli.reachability.place_reachability import PlaceReachability

_KINDS = (
    ("in a line from where it waits", Colour.GOOD),
    ("reached", Colour.FAIR),
    ("not reached", Colour.BAD),
)


def reach_picture(cell: Cell, reaches: Sequence[PlaceReachability]) -> Picture:
    """Draw the reachable share of each place.

    Args:
        cell: The cell.
        reaches: Reachability of its places.

    Returns:
        The picture.
    """
    arm = Arm(cell.robot)
    nodes = [
        DrawnNode(tip, _KINDS[kind][1], "", is_main=False)
        for each in reaches
        for tip, kind in zip(each.tips, _kinds_of(each), strict=True)
    ]
    n_reached = sum(int(each.is_reached.sum()) for each in reaches)
    total = sum(len(each.tips) for each in reaches)
    words = (f"{n_reached} of {total} tool poses are reached", f"{len(reaches)} places")
    bars = tuple(
        CoverageBar(each.place, tuple(_kinds_of(each).count(kind) for kind in range(len(_KINDS))))
        for each in reaches
    )
    return Picture(
        f"Reach of {cell.name}", words, (*solids(cell), *arm_solids(cell, arm)), (skeleton(cell, arm),),
        tuple(nodes), Coverage("tool poses in each place", _KINDS, bars), (),
    )  # fmt: skip


def _kinds_of(each: PlaceReachability) -> list[int]:
    """Index of the kind of each pose."""
    return [
        0 if in_line else 1 if reached else 2
        for in_line, reached in zip(each.is_reached_in_line, each.is_reached, strict=True)
    ]
