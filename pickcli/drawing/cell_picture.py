"""Picture of a cell alone: what stands in it, the arm at home, and its named configurations."""

from __future__ import annotations

from pickcli.cell.cell import Cell
from pickcli.cell.place import Place
from pickcli.drawing.picture import Colour, DrawnNode, Picture
from pickcli.drawing.scenery import arm_solids, node, skeleton, solids
from pickcli.kinematics.arm import Arm


def cell_picture(cell: Cell) -> Picture:
    """Picture of a cell, with the tip of the tool in every named configuration, and its places.

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
        (*(node(each, arm) for each in named.values()), *_mouths(cell)),
        None,
        (),
    )


def _mouths(cell: Cell) -> tuple[DrawnNode, ...]:
    """Where the places are reached that have no configuration of their name."""
    return tuple(
        _mouth(cell, place) for name, place in cell.places.items() if name not in cell.configurations
    )


def _mouth(cell: Cell, place: Place) -> DrawnNode:
    """The middle of the way into a place."""
    T_world_mouth = cell.T_world_place(place) @ place.access.T_place_mouth
    ink = Colour.DELIVERY if place.access.is_from_above else Colour.BIN
    return DrawnNode(T_world_mouth[:3, 3], ink, place.name)
