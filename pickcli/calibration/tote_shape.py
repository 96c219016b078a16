"""The faces of a tote that the lip of a cup can be put on: insides of walls, and the top of the rim."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.shapes import Body
from pickcli.errors import InputError
from pickcli.geometry import Array, inverse

SIDES = {"left": (0.0, 1.0), "right": (0.0, -1.0), "near": (-1.0, 0.0), "far": (1.0, 0.0)}  # x, y outwards
SAME_HEIGHT = 1e-4  # m between the tops of a wall and of its flange, up to which they are one face


@dataclass(frozen=True, eq=False)
class ToteFace:
    """A flat face of the tote, in the frame of the tote: the middle of its inner floor, z up.

    Attributes:
        name: E.g. "wall left" or "rim near".
        normal: (3,) unit vector, out of the solid.
        middle: (3,) m, a point of the face: of a rim its middle, of a wall that of its upper edge.
        along: (3,) unit vector along the face, level.
        half_length: m from the middle to either end along it.
        width: m across it: the width of a rim, the height of a wall.
        bodies: Names of the solids of this side of the tote.
    """

    name: str
    normal: Array
    middle: Array
    along: Array
    half_length: float
    width: float
    bodies: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class ToteShape:
    """What is known of a tote's shape.

    Attributes:
        walls: Inner faces of the walls by side: left (at greater y), right, near (at smaller x) and far.
        rims: Tops of the rim by side.
        T_world_tote: (4, 4) where the cell says that the tote stands.
    """

    walls: dict[str, ToteFace]
    rims: dict[str, ToteFace]
    T_world_tote: Array

    @property
    def long_sides(self) -> tuple[str, str]:
        """The two sides with the longer walls."""
        is_along_x = self.walls["left"].half_length >= self.walls["near"].half_length
        return ("left", "right") if is_along_x else ("near", "far")

    @property
    def short_sides(self) -> tuple[str, str]:
        """The two sides with the shorter walls."""
        return ("near", "far") if self.long_sides == ("left", "right") else ("left", "right")


def tote_shape(cell: Cell) -> ToteShape:
    """Return the faces of a cell's tote.

    Args:
        cell: The cell.

    Returns:
        The shape.

    Raises:
        InputError: The cell has no tote.
    """
    if cell.tote is None:
        raise InputError(f"cell {cell.name}: has no tote to be located (docs/formats/cell.md)")
    place = cell.tote.place
    T_world_tote = cell.T_world_place(place)
    bodies = {body.name: body for body in cell.tote.bodies}
    walls, rims = {}, {}
    for side, outwards in SIDES.items():
        wall, flange = bodies[f"tote_wall_{side}"], bodies[f"tote_flange_{side}"]
        names, out = (wall.name, flange.name), np.array([*outwards, 0.0])
        low, high = place.room.low, place.room.high
        along = np.array([abs(out[1]), abs(out[0]), 0.0])
        half_length = float(along @ (high - low)) / 2
        middle = np.where(out > 0.0, high, np.where(out < 0.0, low, 0.0))
        middle[2] = high[2]
        height = float(high[2] - low[2])
        walls[side] = ToteFace(f"wall {side}", -out, middle, along, half_length, height, names)
        rim, width = _rim(T_world_tote, wall, flange, out)
        up = np.array([0.0, 0.0, 1.0])
        rims[side] = ToteFace(f"rim {side}", up, rim, along, half_length, width, names)
    return ToteShape(walls, rims, T_world_tote)


def _rim(T_world_tote: Array, wall: Body, flange: Body, out: Array) -> tuple[Array, float]:
    """Return the middle (3,) of the top of a rim in the tote's frame, and its width, m.

    out: (3,) unit vector out of the tote, across the rim.
    """
    inner, outer = (_extent(T_world_tote, body) for body in (wall, flange))
    top = float(outer[1][2])
    solids = [outer] if abs(top - float(inner[1][2])) > SAME_HEIGHT else [inner, outer]
    corners = np.array(solids).reshape(-1, 3)
    across = corners @ out
    middle = (across.min() + across.max()) / 2 * out
    middle[2] = top
    return middle, float(np.ptp(across))


def _extent(T_world_tote: Array, body: Body) -> tuple[Array, Array]:
    """Return the lower and upper corner (3,) of an upright box of the cell, m in the tote's frame."""
    T = inverse(T_world_tote) @ body.T_parent_shape
    half = body.shape.reach(T[:3, :3])
    return T[:3, 3] - half, T[:3, 3] + half
