"""The suction regions of an item: one task space region per face on which the cup fits, whole or across."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pickcli.cell.hollow import Hollow
from pickcli.cell.item import LEAST_SHARE, Item
from pickcli.cell.shapes import ShapeKind
from pickcli.cell.tool import Tool
from pickcli.geometry import Array, cross, pose
from pickcli.grasping.lip_coverage import kept_vacuum
from pickcli.grasping.region import TaskSpaceRegion

MOST_ALONG = 2.0  # times the cup's radius, from the middle of a narrow face along it
N_CACHED = 256  # items of a scene, for each of some tools


@dataclass(frozen=True, eq=False)
class Face:
    """A suctionable part of an item's surface.

    Attributes:
        name: Outward direction in the item frame ("+x" to "-z"), "mantle", "sphere", or the bottom of a
            hollow, e.g. "+z/bowl".
        region: Tool poses in the item frame: tip on the surface, +z into the item.
    """

    name: str
    region: TaskSpaceRegion


def faces(item: Item, tool: Tool) -> tuple[Face, ...]:
    """Find all faces of an item that the cup can be put on and that seal.

    Args:
        item: The item.
        tool: The tool with the cup.

    Returns:
        The faces, those that the whole cup fits on first; () if the item has none.
    """
    wide = tuple(face for face in wide_faces(item, tool) if item.seals[face.name] > 0.0)
    return wide + narrow_faces(item, tool)


@lru_cache(maxsize=N_CACHED)
def wide_faces(item: Item, tool: Tool) -> tuple[Face, ...]:
    """Find all faces of an item on which the whole cup fits, whether they seal or not. Cached.

    Args:
        item: The item.
        tool: The tool with the cup.

    Returns:
        The faces; () if the item has none.
    """
    inset = tool.cup.radius + item.seal_inset
    if item.shape.kind is ShapeKind.SPHERE:
        return _sphere_faces(item, tool)
    is_box = item.shape.kind is ShapeKind.BOX
    found = _box_faces(item, inset) if is_box else _cylinder_faces(item, inset, tool.cup.stroke)
    bottoms = (_bottom(item, hollow, inset) for hollow in item.hollows)
    return tuple(face for face in (*found, *bottoms) if face is not None)


@lru_cache(maxsize=N_CACHED)
def narrow_faces(item: Item, tool: Tool) -> tuple[Face, ...]:
    """Find all faces of a box that are narrower than the cup and yet seal across it. Cached.

    The cup is put on the middle line, near the middle of the face, where pose errors shift it least.

    Args:
        item: The item.
        tool: The tool with the cup.

    Returns:
        The faces under which the pump keeps enough vacuum if the pose is exact; () if there are none.
    """
    if item.shape.kind is not ShapeKind.BOX:
        return ()
    cup = tool.cup
    inset = cup.radius + item.seal_inset
    found: list[Face] = []
    for name, outward, low, high in _rectangles(item):
        centre, R = (low + high) / 2, into(outward)
        half = np.abs(R[:, :2].T) @ (high - low) / 2
        if not half.min() < inset <= half.max() or item.seals[name] <= 0.0:
            continue
        if kept_vacuum(item, name, centre, cup) < LEAST_SHARE:
            continue
        along = np.where(half < inset, 0.0, np.minimum(half - inset, MOST_ALONG * cup.radius))
        bounds = np.zeros((6, 2))
        bounds[:2] = np.stack([-along, along], axis=1)
        found.append(Face(name, TaskSpaceRegion(pose(centre, R=R), np.eye(4), bounds)))
    return tuple(found)


def sagitta(radius: float, cup_radius: float) -> float:
    """Return how far a curved surface bulges into a cup that is pressed on with its rim.

    Args:
        radius: m, of the surface.
        cup_radius: m.

    Returns:
        m.
    """
    return float(radius - np.sqrt(max(0.0, radius**2 - cup_radius**2)))


def into(outward: Array) -> Array:
    """Return a tool orientation that points into a surface.

    Args:
        outward: (3,) normal of the surface, of any length.

    Returns:
        (3, 3) rotation whose z axis is -outward; its x axis is any perpendicular direction.
    """
    z = -outward / np.linalg.norm(outward)
    helper = np.array([0.0, 0.0, 1.0]) if abs(z[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    x = cross(helper, z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, cross(z, x), z])


def _flat(name: str, outward: Array, low: Array, high: Array, inset: float) -> Face | None:
    """Return the part of a rectangle (corners (3,), normal ``outward``) ``inset`` inside its edges."""
    centre, R = (low + high) / 2, into(outward)
    half_range = np.abs(R[:, :2].T) @ (high - low) / 2 - inset  # along the tool's x and y axes
    if float(half_range.min()) < 0.0:
        return None
    bounds = np.zeros((6, 2))
    bounds[:2] = np.stack([-half_range, half_range], axis=1)
    return Face(name, TaskSpaceRegion(pose(centre, R=R), np.eye(4), bounds))


def _box_faces(item: Item, inset: float) -> Iterator[Face | None]:
    for name, outward, low, high in _rectangles(item):
        yield _flat(name, outward, low, high, inset)


def _rectangles(item: Item) -> Iterator[tuple[str, Array, Array, Array]]:
    """Yield the faces of a box: name, normal, and two opposite corners of the part that seals."""
    half = item.shape.extents / 2
    for name in item.shape.face_names:
        outward = _outward(name)
        low, high = item.area(name)
        low, high = np.maximum(low, -half), np.minimum(high, half)
        on_it = outward != 0.0
        yield name, outward, np.where(on_it, outward * half, low), np.where(on_it, outward * half, high)


def _cylinder_faces(item: Item, inset: float, stroke: float) -> Iterator[Face | None]:
    radius, length = item.shape.size
    for name in ("+z", "-z"):
        yield _disc(item, name, radius, inset)
    ends = item.area("mantle")[:, 2]
    low_z, high_z = max(-length / 2, ends[0]) + inset, min(length / 2, ends[1]) - inset
    # On the mantle the bellows must compensate the bulge.
    if high_z >= low_z and radius > inset and sagitta(radius, inset) <= 0.75 * stroke:
        bounds = np.zeros((6, 2))
        bounds[2], bounds[5] = (low_z, high_z), (-np.pi, np.pi)
        T_region_tool = pose([radius, 0.0, 0.0], R=into(np.array([1.0, 0.0, 0.0])))
        yield Face("mantle", TaskSpaceRegion(np.eye(4), T_region_tool, bounds))


def _bottom(item: Item, hollow: Hollow, inset: float) -> Face | None:
    """Return the part of the bottom of a hollow in which the whole cup keeps the inset from its sides."""
    if hollow.radius is not None:
        return _disc(item, hollow.bottom, hollow.radius, inset)
    low, high = item.area(hollow.bottom)
    low[hollow.axis] = high[hollow.axis] = item.height(hollow.bottom)
    return _flat(hollow.bottom, _outward(hollow.bottom), low, high, inset)


def _disc(item: Item, name: str, radius: float, inset: float) -> Face | None:
    """Return the part of a round flat face of a cylinder, about its axis, ``inset`` inside its edge."""
    if radius < inset:
        return None
    # The square inscribed in the disc of allowed cup centres, plus the inset around it.
    half = np.full(2, (radius - inset) / np.sqrt(2.0) + inset)
    low, high = item.area(name)
    low, high = np.append(np.maximum(low[:2], -half), 0.0), np.append(np.minimum(high[:2], half), 0.0)
    low[2] = high[2] = item.height(name)
    return _flat(name, _outward(name), low, high, inset)


def _sphere_faces(item: Item, tool: Tool) -> tuple[Face, ...]:
    radius = item.shape.size[0]
    if sagitta(radius, tool.cup.radius) > 0.75 * tool.cup.stroke:
        return ()
    bounds = np.zeros((6, 2))
    bounds[4], bounds[5] = (-np.pi / 2, np.pi / 2), (-np.pi, np.pi)
    T_region_tool = pose([radius, 0.0, 0.0], R=into(np.array([1.0, 0.0, 0.0])))
    return (Face("sphere", TaskSpaceRegion(np.eye(4), T_region_tool, bounds)),)


def rolled(T_item_tip: Array, angle: Array | float) -> Array:
    """Turn cup placements about the cup's own axis.

    Args:
        T_item_tip: (..., 4, 4) tool frame in the item's.
        angle: (...) rad; its shape and that of the placements are broadcast.

    Returns:
        (..., 4, 4) the turned placements.
    """
    return _rotated(T_item_tip, angle, 0, 1)


def tilted(T_item_tip: Array, angle: Array | float) -> Array:
    """Tilt cup placements about the tool's y axis, so that their x axis rises.

    Args:
        T_item_tip: (..., 4, 4) tool frame in the item's.
        angle: (...) rad; its shape and that of the placements are broadcast.

    Returns:
        (..., 4, 4) the tilted placements.
    """
    return _rotated(T_item_tip, angle, 2, 0)


def _rotated(T: Array, angle: Array | float, i: int, j: int) -> Array:
    """Rotate poses (..., 4, 4) by angles (...) that take their axis i towards their axis j."""
    angle = np.asarray(angle)
    out = np.broadcast_to(T, (*np.broadcast_shapes(T.shape[:-2], angle.shape), 4, 4)).copy()
    c, s = np.cos(angle)[..., None], np.sin(angle)[..., None]
    a, b = T[..., :3, i], T[..., :3, j]
    out[..., :3, i], out[..., :3, j] = c * a + s * b, c * b - s * a
    return out


def flat_normal(face: str) -> Array | None:
    """Return the normal of a flat face.

    Args:
        face: Name of the face.

    Returns:
        (3,) unit vector in the item frame, outwards; None for a curved face.
    """
    return None if face in ("mantle", "sphere") else _outward(face)


def _outward(face: str) -> Array:
    return np.asarray(np.eye(3)["xyz".index(face[1])] * (1.0 if face[0] == "+" else -1.0))


def tilt_on(face: str, T_item_tip: Array) -> Array:
    """Return the angle between the cup's axis and the normal of the face under it.

    Args:
        face: Name of the face.
        T_item_tip: (..., 4, 4) tool frame in the item's.

    Returns:
        (...) rad.
    """
    outward = flat_normal(face)
    if outward is None:
        outward = T_item_tip[..., :3, 3] * (1.0, 1.0, 0.0 if face == "mantle" else 1.0)
    cosine = -(T_item_tip[..., :3, 2] * outward).sum(axis=-1) / np.sqrt((outward**2).sum(axis=-1))
    return np.asarray(np.arccos(np.minimum(1.0, np.maximum(-1.0, cosine))))
