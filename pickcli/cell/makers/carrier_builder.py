"""Builds the carriers that a cell file lists under ``places``, with their solids and places."""

from __future__ import annotations

from pathlib import Path
from typing import assert_never

import numpy as np

from pickcli.cell.conveyor import Conveyor
from pickcli.cell.makers.grid import build_grid
from pickcli.cell.place import Access, Place, Room
from pickcli.cell.pod_tolerance import Displacement
from pickcli.cell.schemas.place_schema import (
    BodiesModel,
    BoxModel,
    ConveyorModel,
    GridModel,
    PartModel,
    PlaceModel,
    TableModel,
)
from pickcli.cell.shapes import Body, Shape, ShapeKind, box, ring
from pickcli.cell.station import Carrier
from pickcli.geometry import Array, pose
from pickcli.meshes.mesh_pieces import mesh_pieces

# m on each side by which the access to a table is wider than its top, as there are no walls
TABLE_OVERHANG = 0.5


def build_carrier(name: str, figures: PlaceModel, folder: Path) -> Carrier:
    """Build the solids and places of a carrier.

    Args:
        name: Name of the carrier in the cell file.
        figures: The carrier as it stands in the cell file.
        folder: The cell's folder, which contains meshes.

    Returns:
        The carrier.

    Raises:
        InputError: A mesh cannot be read.
    """
    T = pose(figures.T_world_place.xyz, rpy=figures.T_world_place.rpy)
    own = figures.displacement
    displacement = Displacement(own.x, own.y, own.yaw)
    conveyor = None
    match figures:
        case GridModel():
            return build_grid(name, figures, T, displacement)
        case BoxModel():
            bodies, place = _box(name, figures)
        case TableModel():
            bodies, place = _table(name, figures)
        case ConveyorModel():
            bodies, place = _belt(name, figures)
            conveyor = Conveyor(
                figures.length,
                figures.width,
                figures.speed.nominal,
                figures.speed.max,
                figures.speed.max_acceleration,
                (figures.window[0], figures.window[1]),
                figures.encoder.resolution,
                figures.encoder.latency,
            )
        case BodiesModel():
            bodies, place = _of_bodies(name, figures, folder)
        case _:
            assert_never(figures)
    return Carrier(name, T, tuple(bodies), {name: place}, displacement, conveyor)


def _box(name: str, figures: BoxModel) -> tuple[list[Body], Place]:
    """Build a box with its origin in the middle of the inner floor."""
    x, y, height = figures.inner
    w = figures.wall_thickness
    outer = (x / 2 + w, y / 2 + w)
    floor = box(f"{name}_floor", (-outer[0], -outer[1], -w), (*outer, 0.0))
    inner = (-x / 2, -y / 2, 0.0), (x / 2, y / 2, height)
    walls = ring(f"{name}_wall", *inner, (-outer[0], -outer[1]), outer)
    access, room = Access.from_above(x, y, height), Room.box(x, y, height)
    return [floor, *walls], Place(name, name, np.eye(4), access, room, (floor.name,))


def _table(name: str, figures: TableModel) -> tuple[list[Body], Place]:
    """Build a table top with its origin in the middle of the upper face."""
    x, y, thickness = figures.size
    top = box(f"{name}_top", (-x / 2, -y / 2, -thickness), (x / 2, y / 2, 0.0))
    access = Access.from_above(x + 2 * TABLE_OVERHANG, y + 2 * TABLE_OVERHANG, 0.0)
    return [top], Place(name, name, np.eye(4), access, Room.box(x, y, figures.height), (top.name,))


def _belt(name: str, figures: ConveyorModel) -> tuple[list[Body], Place]:
    """Build a belt with its origin in the middle of the infeed edge, on the running surface."""
    x, y = figures.length, figures.width
    belt = box(f"{name}_frame", (0.0, -y / 2, -figures.thickness), (x, y / 2, 0.0))
    access = Access.from_above(x + 2 * TABLE_OVERHANG, y + 2 * TABLE_OVERHANG, 0.0)
    T = pose((x / 2, 0.0, 0.0))
    return [belt], Place(name, name, T, access, Room.box(x, y, figures.height), (belt.name,))


def _of_bodies(name: str, figures: BodiesModel, folder: Path) -> tuple[list[Body], Place]:
    """Build the stated bodies, and a place in the room between them."""
    bodies = [body for part in figures.bodies for body in _part(part, folder)]
    support = tuple(
        body.name for part in figures.bodies if part.name in figures.support for body in _part(part, folder)
    )
    low, high = np.array(figures.room.lower), np.array(figures.room.upper)
    (x, y, height), middle = (high - low).tolist(), (low + high) / 2
    if figures.access == "front":
        floor, top = -figures.lip, height - figures.lip
        room = Room((0.0, x), (-y / 2, y / 2), floor, floor, top, top, 0.0, 0.0)
        access = Access.from_front(y, height - figures.lip)
        T = pose((low[0], middle[1], low[2] + figures.lip))
        return bodies, Place(name, name, T, access, room, support)
    beside, rim = (0.0, height) if figures.walls else (2 * TABLE_OVERHANG, 0.0)
    access = Access.from_above(x + beside, y + beside, rim)
    T = pose((middle[0], middle[1], low[2]))
    return bodies, Place(name, name, T, access, Room.box(x, y, height), support)


def _part(part: PartModel, folder: Path) -> list[Body]:
    """Build the body of a part; of a mesh, numbered boxes around its convex pieces."""
    T = pose(part.xyz, rpy=part.rpy)
    if part.box is not None:
        return [Body(part.name, Shape(ShapeKind.BOX, part.box), T)]
    if part.cylinder is not None:
        return [Body(part.name, Shape(ShapeKind.CYLINDER, part.cylinder), T)]
    assert part.mesh is not None
    pieces = mesh_pieces(folder / part.mesh, part.scale)
    return [_around(f"{part.name}_{k}", points, T) for k, points in enumerate(pieces, start=1)]


def _around(name: str, points: Array, T: Array) -> Body:
    """The box around points (V, 3) in the frame T (4, 4), along its axes."""
    low, high = points.min(axis=0), points.max(axis=0)
    size = tuple(float(v) for v in high - low)
    return Body(name, Shape(ShapeKind.BOX, size), T @ pose((low + high) / 2))
