"""Builds the tote from the figures in a cell file: floor, four walls, and the flange around the rim."""

from __future__ import annotations

from pickcli.cell.place import Access, Place, Room
from pickcli.cell.schemas.cell_schema import ToteModel
from pickcli.cell.shapes import box, ring
from pickcli.cell.station import TOTE, Tote
from pickcli.geometry import pose


def build_tote(figures: ToteModel) -> Tote:
    """Build the tote's boxes in the world frame, and its place at the centre of the inner floor.

    Args:
        figures: The tote as it stands in the cell file.

    Returns:
        The tote.
    """
    (x0, y0, z0), (x1, y1, z1) = figures.inner.lower, figures.inner.upper
    w = figures.wall_thickness
    floor = box("tote_floor", (x0 - w, y0 - w, z0 - w), (x1 + w, y1 + w, z0))
    walls = ring("tote_wall", (x0, y0, z0), (x1, y1, z1), (x0 - w, y0 - w), (x1 + w, y1 + w))
    outer_low, outer_high = figures.flange.lower, figures.flange.upper
    flange = ring(
        "tote_flange",
        (x0 - w, y0 - w, outer_low[2]),
        (x1 + w, y1 + w, outer_high[2]),
        (outer_low[0], outer_low[1]),
        (outer_high[0], outer_high[1]),
    )
    bodies = (floor, *walls, *flange)
    place = Place(
        name=TOTE,
        carrier=TOTE,
        T_carrier_place=pose(((x0 + x1) / 2, (y0 + y1) / 2, z0)),
        access=Access.from_above(x1 - x0, y1 - y0, z1 - z0),
        room=Room.box(x1 - x0, y1 - y0, z1 - z0),
        support=(floor.name,),
    )
    return Tote(place, bodies)
