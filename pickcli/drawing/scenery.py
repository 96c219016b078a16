"""Scenery of pictures: the cell's solids, the arm at home as solids and skeleton, and tool paths."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull

from pickcli.cell.cell import Cell, NamedConfiguration
from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.cell.station import POD, TOTE
from pickcli.drawing.picture import Colour, DrawnLine, DrawnNode, DrawnSolid
from pickcli.geometry import Array, transform_points
from pickcli.kinematics.arm import Arm

POINT_DISTANCE = 0.04  # rad or m of a joint between two points of a drawn path

_INKS = {
    "home": Colour.HOME,
    "bin": Colour.BIN,
    "camera": Colour.CAMERA,
    "tote": Colour.DELIVERY,
    "drop": Colour.DELIVERY,
}

_SOLIDS = {POD: Colour.POD, TOTE: Colour.TOTE}

_MAIN = ("home", "bin", "tote")

# Corners by the bits of their index: x, then y, then z.
_CORNERS = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)]) - 0.5
_QUADRANGLES = np.array([[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]])
_ANGLES = 2 * np.pi * np.arange(20) / 20  # angles of the corners that approximate a circle


def solids(cell: Cell) -> tuple[DrawnSolid, ...]:
    """Return the boxes of carriers and obstacles, without floors and walls of the hall.

    Args:
        cell: The cell.

    Returns:
        The boxes.
    """
    parts = [
        (body, carrier.T_world_carrier, _SOLIDS.get(carrier.name, Colour.PLACE))
        for carrier in cell.carriers.values()
        for body in carrier.bodies
    ]
    parts += [(body, np.eye(4), Colour.OBSTACLE) for body in cell.obstacles.bodies]
    return tuple(
        DrawnSolid(_corners(T @ body.T_parent_shape, body), _QUADRANGLES, ink)
        for body, T, ink in parts
        if not _is_floor(body)
    )


def arm_solids(cell: Cell, arm: Arm) -> tuple[DrawnSolid, ...]:
    """Return the shapes of all links with the arm at home, with meshes as convex pieces.

    Args:
        cell: The cell.
        arm: The arm.

    Returns:
        The solids.
    """
    robot = cell.robot
    poses = (robot.T_world_base, *arm.chain(robot.tool.default_state).fk(_q_home(cell)))
    return tuple(
        _convex(transform_points(T @ body.T_parent_shape, _outline(body.shape)))
        for link, T in zip(robot.links, poses, strict=True)
        for body in link.bodies
    )


def skeleton(cell: Cell, arm: Arm) -> DrawnLine:
    """Return the skeleton of the arm at home, or in its first configuration: link origins from base to tip.

    Args:
        cell: The cell.
        arm: The arm.

    Returns:
        The line.
    """
    robot, q = cell.robot, _q_home(cell)
    frames = np.asarray(arm.chain(robot.tool.default_state).fk(q))[:, :3, 3]
    by_link = dict(zip((joint.child for joint in robot.joints), frames, strict=True))
    parents = {joint.child: joint.parent for joint in robot.joints}
    link, way = robot.tool.last_link, [arm.tip(q, robot.tool.default_state)[:3, 3]]
    while link in by_link:
        way.append(by_link[link])
        link = parents[link]
    return DrawnLine(np.array([robot.T_world_base[:3, 3], *reversed(way)]), Colour.ARM, "the arm at home")


def node(named: NamedConfiguration, arm: Arm) -> DrawnNode:
    """Return the position of the tool tip in a named configuration.

    Args:
        named: The configuration.
        arm: The arm.

    Returns:
        The node.
    """
    ink = _INKS.get(named.kind, Colour.OTHER)
    return DrawnNode(arm.tip(named.q, named.tool_state)[:3, 3], ink, named.name, named.kind in _MAIN)


def tool_path(waypoints: Array, arm: Arm) -> Array:
    """Compute the path of the tip along a joint-space polyline, with the tool in its default state.

    Args:
        waypoints: (N, n) configurations.
        arm: The arm.

    Returns:
        (K, 3) m in the world.
    """
    counts = np.maximum(
        np.ceil(np.abs(np.diff(waypoints, axis=0)).max(axis=1) / POINT_DISTANCE).astype(int), 1
    )
    pieces = [
        a + (b - a) * (np.arange(n) / n)[:, None]
        for a, b, n in zip(waypoints[:-1], waypoints[1:], counts, strict=True)
    ]
    return np.asarray(arm.tips(np.vstack([*pieces, waypoints[-1:]]), arm.robot.tool.default_state)[:, :3, 3])


def _q_home(cell: Cell) -> Array:
    """Configuration (n,) in which the arm is drawn."""
    named = list(cell.configurations.values())
    return next((each.q for each in named if each.kind == "home"), named[0].q)


def _outline(shape: Shape) -> Array:
    """Points (K, 3) in the shape's frame whose hull is drawn."""
    if shape.kind is ShapeKind.HULL:
        return np.array(shape.vertices)
    if shape.kind is ShapeKind.BOX:
        return np.asarray(_CORNERS * shape.extents)
    if shape.kind is ShapeKind.CYLINDER:
        radius, length = shape.size
        rings = [(radius, z) for z in (-length / 2, length / 2)]
    else:
        rings = [
            (shape.size[0] * np.sin(a), shape.size[0] * np.cos(a)) for a in np.pi * np.arange(1, 10) / 10
        ]
    return np.array([(r * np.cos(a), r * np.sin(a), z) for r, z in rings for a in _ANGLES])


def _convex(points: Array) -> DrawnSolid:
    """Hull of points, as a part of the arm."""
    hull = ConvexHull(points)
    numbers = np.full(len(points), -1)
    numbers[hull.vertices] = np.arange(len(hull.vertices))
    return DrawnSolid(points[hull.vertices], numbers[hull.simplices], Colour.ARM)


def _corners(T: Array, body: Body) -> Array:
    """Corners (8, 3) of the box around a shape."""
    return np.asarray(_CORNERS * body.shape.extents @ T[:3, :3].T + T[:3, 3])


def _is_floor(body: Body) -> bool:
    return bool(np.sort(body.shape.extents)[1] > 3.0)
