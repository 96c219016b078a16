"""Cartons as items that a tool grasps: boxes that a cup holds by their upper side, and by no other."""

from __future__ import annotations

from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.palletizing.pallet_order import Carton

YEAR = 2100  # in the files of items: of no challenge, so that no other item has it
TOP = "+z"
SEAL = 0.7  # share of full vacuum that a pump of 60 l/min keeps: board leaks, and so does tape over the joint
INSET = 0.005  # m that the rim of a cup keeps from edges


def carton_item(carton: Carton) -> Item:
    """Return a carton as an item.

    Args:
        carton: The carton.

    Returns:
        A box as it stands, its length along x, with the seals that the reference pump keeps.
    """
    shape = Shape(ShapeKind.BOX, carton.size)
    return Item(
        name=carton.id,
        year=YEAR,
        shape=shape,
        mass=carton.mass,
        bonus=0,
        seals={face: SEAL if face == TOP else 0.0 for face in shape.face_names},
        seal_source="ours: corrugated board, taped; only the upper side is held",
        why_not="",
        seal_inset=INSET,
        speed_scale=1.0,
        folded="",
        source="the order of the pallet",
    )
