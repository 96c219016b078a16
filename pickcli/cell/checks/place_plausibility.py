"""Warnings for places that are valid but implausible: tilted, tiny, or standing in each other."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.place import Place
from pickcli.cell.schemas.cell_schema import CellModel
from pickcli.cell.schemas.pose_schema import PoseModel
from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.cell.station import POD, TOTE, Carrier
from pickcli.files.file_warnings import FileWarnings
from pickcli.files.source import Key
from pickcli.geometry import Array, pose

LARGE_LEAN = 0.1  # rad, lean of the pod beyond which it is reported
LARGE_INTRUSION = 0.005  # m, overlap of a solid and a place beyond which it is reported
HALF_TURN = 3.2  # rad, beyond which an angle is written as one of the other sign
NARROW, LOW = 0.02, 0.01  # m, width and height of a place that hardly any item enters


def warn_of_places(warnings: FileWarnings, cell: Cell, model: CellModel) -> None:
    """Warn of places whose pose or size is possible but probably not meant.

    Args:
        warnings: Collects them.
        cell: The cell.
        model: The cell as it stands in the file.
    """
    _pod(warnings, cell)
    _turned(warnings, model)
    _narrow(warnings, cell)
    _blocked(warnings, cell)
    _overlapping(warnings, cell)


def _pod(warnings: FileWarnings, cell: Cell) -> None:
    lean = math.acos(min(1.0, max(-1.0, float(cell.T_world_pod[2, 2]))))
    if cell.pod.bins and lean > LARGE_LEAN:
        text = f"the shelf leans by {math.degrees(lean):.0f} degrees, and nothing lies in it any more; "
        warnings.add("tilted_pod", "pod", ("pod", "T_world_pod"), f"{text}is rpy in rad, roll first?")


def _turned(warnings: FileWarnings, model: CellModel) -> None:
    """Warn of angles beyond half a turn, such as 5 degrees that were meant to be rad."""
    stated: dict[str, tuple[Key, PoseModel | None]] = {
        "robot": (("robot", "T_world_base"), model.robot.T_world_base),
        **{
            name: (("robots", name, "T_world_base"), each.T_world_base) for name, each in model.robots.items()
        },
        POD: (("pod", "T_world_pod"), None if model.pod is None else model.pod.T_world_pod),
        **{name: (("places", name, "T_world_place"), at.T_world_place) for name, at in model.places.items()},
    }
    for name, (key, T) in stated.items():
        angle = 0.0 if T is None else max(T.rpy, key=abs)
        if abs(angle) > HALF_TURN:
            text = f"{angle:g} rad is {math.degrees(angle):.0f} degrees; is it in rad?"
            warnings.add("odd_angle", name, (*key, "rpy"), text)


def _narrow(warnings: FileWarnings, cell: Cell) -> None:
    for name, place in cell.places.items():
        x, y, z = place.room.size
        if min(x, y) < NARROW or z < LOW:
            text = f"it has {1e3 * x:.3g} x {1e3 * y:.3g} x {1e3 * z:.3g} mm (x, y, z) for items; are these "
            carrier = name if name == TOTE else place.carrier
            key: Key = (carrier,) if carrier in (POD, TOTE) else ("places", carrier)
            warnings.add("narrow_place", name, key, f"{text}in m and in that order?")


def _blocked(warnings: FileWarnings, cell: Cell) -> None:
    """Warn of obstacles that reach into the room of a place."""
    for i, body in enumerate(cell.obstacles.bodies):
        into = [name for name, place in cell.places.items() if _overlap(_room(cell, place), body)]
        if into:
            text = f"{body.name} stands in {', '.join(into)}, where items should; correct its corners, or "
            text += "the pose or size of what it stands in"
            warnings.add("blocked_place", body.name, ("obstacles", i), text)


def _overlapping(warnings: FileWarnings, cell: Cell) -> None:
    """Warn of carriers that stand in each other: one reaches into a place of another."""
    carriers = list(cell.carriers.values())
    for i, carrier in enumerate(carriers):
        into = [other.name for other in carriers[:i] if _meet(cell, carrier, other)]
        if into:
            text = f"{carrier.name} stands in {', '.join(into)}; correct the pose or the size of one"
            key: Key = (carrier.name,) if carrier.name in (POD, TOTE) else ("places", carrier.name)
            warnings.add("blocked_place", carrier.name, key, text)


def _meet(cell: Cell, a: Carrier, b: Carrier) -> bool:
    rooms_a, rooms_b = ([_room(cell, place) for place in each.places.values()] for each in (a, b))
    pairs = [
        *((room, body) for room in rooms_a for body in (*_standing(b), *rooms_b)),
        *((room, body) for room in rooms_b for body in _standing(a)),
    ]
    return any(_overlap(*pair) for pair in pairs)


def _standing(carrier: Carrier) -> Iterator[Body]:
    """Bodies of a carrier in the world frame."""
    for body in carrier.bodies:
        yield Body(body.name, body.shape, carrier.T_world_carrier @ body.T_parent_shape)


def _room(cell: Cell, place: Place) -> Body:
    """The box around a place's room, in the world frame."""
    low, high = place.room.low, place.room.high
    T = cell.T_world_place(place) @ pose((low + high) / 2)
    return Body(place.name, Shape(ShapeKind.BOX, tuple(float(side) for side in high - low)), T)


def _overlap(a: Body, b: Body) -> bool:
    """Whether the boxes around two bodies overlap by over ``LARGE_INTRUSION`` along the axes of both."""
    between = b.T_parent_shape[:3, 3] - a.T_parent_shape[:3, 3]
    axes = np.hstack([a.T_parent_shape[:3, :3], b.T_parent_shape[:3, :3]])
    reaches: list[Array] = [
        np.abs(axes.T @ each.T_parent_shape[:3, :3]) @ (each.shape.extents / 2) for each in (a, b)
    ]
    return bool((reaches[0] + reaches[1] - np.abs(axes.T @ between) > LARGE_INTRUSION).all())
