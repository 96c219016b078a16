"""Builds a shelf of rows and columns from the figures in a cell file: boards, walls and places."""

from __future__ import annotations

import numpy as np

from pickcli.cell.place import Access, Place, Room
from pickcli.cell.pod_tolerance import Displacement
from pickcli.cell.schemas.place_schema import GridModel
from pickcli.cell.shapes import Body, Shape, ShapeKind, box
from pickcli.cell.station import Carrier
from pickcli.geometry import Array, pose


def build_grid(name: str, figures: GridModel, T_world_carrier: Array, displacement: Displacement) -> Carrier:
    """Build the boards, walls and places of a grid shelf.

    Shelf frame: origin in the middle of the lower front edge, +x into the shelf, +y left as seen by the
    robot.

    Args:
        name: Name of the shelf.
        figures: The shelf as it stands in the cell file.
        T_world_carrier: (4, 4) nominal pose of the shelf.
        displacement: Bounds of its displacement from that pose.

    Returns:
        The shelf.
    """
    floors = _floors(figures)
    bodies = [*_walls(name, figures), _board(f"{name}_top", figures, floors[0] + figures.rows[0])]
    places: list[Place] = []
    for i, floor in enumerate(floors):
        board = _board(f"{name}_floor_{i + 1}", figures, floor - figures.board_thickness)
        bodies += [board, *_lip(f"{name}_lip_{i + 1}", figures, floor)]
        places += [_place(name, figures, floor, i, j, board.name) for j in range(len(figures.columns))]
    return Carrier(
        name, T_world_carrier, tuple(bodies), {place.name: place for place in places}, displacement
    )


def place_names(name: str, figures: GridModel) -> tuple[tuple[str, ...], ...]:
    """Return the names of the places of a grid.

    Args:
        name: Name of the shelf.
        figures: The shelf as it stands in the cell file.

    Returns:
        A tuple for each row from the top, each from the left: the stated names, else row and column from 1.
    """
    if figures.names is not None:
        return figures.names
    columns = range(1, len(figures.columns) + 1)
    return tuple(tuple(f"{name}_{i}_{j}" for j in columns) for i in range(1, len(figures.rows) + 1))


def _drop(figures: GridModel) -> float:
    """Drop of every board from front to back, m."""
    return float(figures.depth * np.tan(figures.floor_slope))


def _floors(figures: GridModel) -> list[float]:
    """Front height of each row's floor, m, from the top row down."""
    # The shelf's lowest point is the lower back edge of the lowest board.
    z = figures.board_thickness + _drop(figures)
    floors = []
    for height in reversed(figures.rows):
        floors.append(z)
        z += height + figures.board_thickness
    return floors[::-1]


def _wall(figures: GridModel) -> float:
    return figures.board_thickness if figures.wall_thickness is None else figures.wall_thickness


def _edges(figures: GridModel) -> list[tuple[float, float]]:
    """Lesser and greater y of the clear inside of every column, m, from the left."""
    wall = _wall(figures)
    y = (sum(figures.columns) + (len(figures.columns) - 1) * wall) / 2
    edges = []
    for width in figures.columns:
        edges.append((y - width, y))
        y -= width + wall
    return edges


def _walls(name: str, figures: GridModel) -> list[Body]:
    """Sides, back, and the dividers between columns, all of the shelf's full height."""
    wall, edges, back = _wall(figures), _edges(figures), figures.depth
    top = _floors(figures)[0] + figures.rows[0] + figures.board_thickness
    left, right = edges[0][1], edges[-1][0]
    dividers = [
        box(f"{name}_divider_{j}", (0.0, low - wall, 0.0), (back, low, top))
        for j, (low, _) in enumerate(edges[:-1], start=1)
    ]
    return [
        box(f"{name}_wall_left", (0.0, left, 0.0), (back, left + wall, top)),
        box(f"{name}_wall_right", (0.0, right - wall, 0.0), (back, right, top)),
        box(f"{name}_back", (back, right - wall, 0.0), (back + wall, left + wall, top)),
        *dividers,
    ]


def _board(name: str, figures: GridModel, underside: float) -> Body:
    """A board across the shelf with its lower front edge at height ``underside``, m."""
    edges, slope = _edges(figures), figures.floor_slope
    width = edges[0][1] - edges[-1][0]
    thickness = figures.board_thickness * np.cos(slope)  # board_thickness is measured vertically
    middle = np.array([figures.depth / 2, (edges[0][1] + edges[-1][0]) / 2, underside - _drop(figures) / 2])
    normal = np.array([np.sin(slope), 0.0, np.cos(slope)])
    size = (float(figures.depth / np.cos(slope)), float(width), float(thickness))
    T = pose(middle + normal * thickness / 2, rpy=(0.0, slope, 0.0))
    return Body(name, Shape(ShapeKind.BOX, size), T)


def _lip(name: str, figures: GridModel, floor: float) -> list[Body]:
    """The bar on the front edge of a board, empty if the shelf has no lips."""
    if figures.lip is None:
        return []
    left, right = _edges(figures)[0][1], _edges(figures)[-1][0]
    lower = floor - figures.board_thickness
    return [box(name, (0.0, right, lower), (figures.lip.depth, left, floor + figures.lip.height))]


def _place(name: str, figures: GridModel, floor: float, i: int, j: int, board: str) -> Place:
    """The place in row i and column j, counted from 0."""
    low, high = _edges(figures)[j]
    lip = 0.0 if figures.lip is None else figures.lip.height
    height, drop, half = figures.rows[i], _drop(figures), (high - low) / 2
    room = Room(
        x_range=(0.0, figures.depth),
        y_range=(-half, half),
        floor_front=-lip,
        floor_back=-lip - drop,
        ceiling_front=height - lip,
        ceiling_back=height - lip - drop,
        slope_from=0.0,
        floor_flat_from=figures.depth if drop > 0.0 else 0.0,
    )
    own = place_names(name, figures)[i][j]
    access = Access.from_front(high - low, height - lip)
    return Place(own, name, pose((0.0, (low + high) / 2, floor + lip)), access, room, (board,))
