"""Markers (visualization_msgs/Marker) of carriers, obstacles and items of a scene."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.export.ros_messages import colour, header, point, ros_pose
from pickcli.export.samples import stamp
from pickcli.geometry import Array
from pickcli.scene.colours import STATIC_COLOURS, item_colour, static_colour
from pickcli.scene.scene import PlacedItem, Scene

CUBE, SPHERE, CYLINDER, POINTS, TRIANGLE_LIST = 1, 2, 3, 8, 11
_TYPES = {ShapeKind.BOX: CUBE, ShapeKind.CYLINDER: CYLINDER, ShapeKind.SPHERE: SPHERE}
Rgba = tuple[float, float, float, float]


def cell_markers(scene: Scene, world: str) -> list[dict[str, Any]]:
    """Create a marker for each static solid, in the namespace of its carrier.

    Args:
        scene: The scene.
        world: Name of the world frame.

    Returns:
        The markers; a point cloud is one marker.
    """
    markers = []
    for carrier in scene.posed_carriers:
        for number, body in enumerate(carrier.bodies):
            T, rgba = carrier.T_world_carrier @ body.T_parent_shape, static_colour(carrier.name)
            markers.append(_marker((carrier.name, number), body.shape, (world, T), rgba, 0))
    if (cloud := scene.cloud) is not None:
        width = np.full(3, 2.0 * cloud.radius)
        points = _placed(("cloud", 0), POINTS, (world, np.eye(4)), width, STATIC_COLOURS["cloud"], 0)
        markers.append({**points, "points": [point(p) for p in cloud.points]})
    return markers


def item_marker(
    scene: Scene, placed: PlacedItem, at: tuple[str, Array], nanoseconds: int
) -> dict[str, Any]:  # fmt: skip
    """Create the marker of an item at a pose.

    Args:
        scene: The scene, for the numbering of items.
        placed: The item.
        at: Name of a frame, and the pose (4, 4) of the item in it.
        nanoseconds: Start of its validity.

    Returns:
        The marker, which replaces earlier ones of the same item.
    """
    number = [each.id for each in scene.items].index(placed.id)
    item = placed.item
    return _marker(("items", number), item.shape, at, item_colour(item), nanoseconds)


def _marker(
    name: tuple[str, int], shape: Shape, at: tuple[str, Array], rgba: Rgba, nanoseconds: int
) -> dict[str, Any]:
    if shape.kind is ShapeKind.HULL:
        marker = _placed(name, TRIANGLE_LIST, at, np.ones(3), rgba, nanoseconds)
        return {**marker, "points": [point(p) for p in _triangles(shape)]}
    return _placed(name, _TYPES[shape.kind], at, shape.extents, rgba, nanoseconds)


def _placed(
    name: tuple[str, int], kind: int, at: tuple[str, Array], scale: Array, rgba: Rgba, nanoseconds: int
) -> dict[str, Any]:
    """Create a marker without expiry that moves with its frame."""
    (group, number), (frame, T) = name, at
    return {
        "header": header(frame, stamp(nanoseconds)),
        "ns": group,
        "id": number,
        "type": kind,
        "action": 0,
        "pose": ros_pose(T),
        "scale": point(scale),
        "color": colour(rgba),
        "lifetime": stamp(0),
        "frame_locked": True,
    }


def _triangles(shape: Shape) -> Array:
    """Corners (3 K, 3) of the triangles of a hull."""
    corners = np.array(shape.vertices)
    return np.asarray(corners[ConvexHull(corners).simplices.ravel()])
