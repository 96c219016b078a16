"""Solids of a pallet: its deck, and the walls of a container; in its frame, on its deck, z up."""

from __future__ import annotations

from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.geometry import pose
from pickcli.palletizing.pallet_order import Pallet

THICKNESS = 0.03  # m, of walls


def deck_body(pallet: Pallet, thickness: float) -> Body:
    """Return the deck, as a box below it.

    Args:
        pallet: The pallet.
        thickness: m.

    Returns:
        The box.
    """
    length, width = pallet.size
    return Body("pallet deck", Shape(ShapeKind.BOX, (length, width, thickness)), pose((0, 0, -thickness / 2)))


def wall_bodies(pallet: Pallet) -> tuple[Body, ...]:
    """Return the walls, from the deck to the height, outside of it.

    Args:
        pallet: The pallet.

    Returns:
        A box for each.
    """
    height, walls = pallet.height - pallet.deck, []
    for side in pallet.walls:
        axis = "xy".index(side[1])
        size, at = [*pallet.size, height], [0.0, 0.0, height / 2]
        at[axis] = (-1.0 if side[0] == "-" else 1.0) * (size[axis] + THICKNESS) / 2
        size[axis] = THICKNESS
        walls.append(Body(f"wall {side}", Shape(ShapeKind.BOX, tuple(size)), pose(at)))
    return tuple(walls)
