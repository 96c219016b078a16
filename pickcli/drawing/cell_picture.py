"""Picture of a cell alone: what stands in it, the arm at home, and its named configurations."""

from __future__ import annotations

from pickcli.cell.cell import Cell
from pickcli.drawing.picture import Picture
from pickcli.drawing.scenery import arm_solids, node, skeleton, solids
from pickcli.kinematics.arm import Arm


def cell_picture(cell: Cell) -> Picture:
    """Picture of a cell, with the tip of the tool in every named configuration.

    Args:
        cell: The cell; it has a named configuration.

    Returns:
        The picture.
    """
    arm, named = Arm(cell.robot), cell.configurations
    places = f"{len(cell.places)} places" if cell.places else "no places to pick from"
    return Picture(
        f"Cell {cell.name}",
        (f"{cell.robot.name}: {arm.n} joints, {len(named)} configurations, {places}",),
        (*solids(cell), *arm_solids(cell, arm)),
        (skeleton(cell, arm),),
        tuple(node(each, arm) for each in named.values()),
        None,
        (),
    )
