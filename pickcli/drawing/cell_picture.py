"""Picture of a cell: static bodies, the arm at home, and named configurations."""

from __future__ import annotations

from pickcli.cell.cell import Cell
from pickcli.cell.place import Place
from pickcli.drawing.picture import Colour, DrawnNode, Picture
from pickcli.drawing.scenery import arm_solids, node, skeleton, solids
from pickcli.kinematics.arm import Arm


def cell_picture(cell: Cell) -> Picture:
    """Draw a cell with the tool tip in every named configuration, and its places.

    Args:
        cell: The cell, with at least one named configuration.

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
        (*(node(each, arm) for each in named.values()), *_mouths(cell)),
        None,
        (),
    )


def _mouths(cell: Cell) -> tuple[DrawnNode, ...]:
    """Nodes for the places without a configuration of the same name."""
    return tuple(
        _mouth(cell, place) for name, place in cell.places.items() if name not in cell.configurations
    )


def _mouth(cell: Cell, place: Place) -> DrawnNode:
    """Node at the centre of a place's mouth."""
    T_world_mouth = cell.T_world_place(place) @ place.access.T_place_mouth
    ink = Colour.DELIVERY if place.access.is_from_above else Colour.BIN
    return DrawnNode(T_world_mouth[:3, 3], ink, place.name)
