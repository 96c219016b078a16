"""Writes the robot as a separate URDF for the physics engine.

The engine cannot use the cell's own URDF: it resolves no packages, reads no COLLADA, treats mimic joints as
independent, and knows nothing of posture, removed links, or a tool in a second file. The written file has the
links and joints that planner and verifier use, with meshes as the same convex pieces.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from scipy.spatial import ConvexHull

from pickcli.cell.robot import Robot
from pickcli.cell.robots.urdf_writer import add_joint, add_link, add_shape, spaced
from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.cell.tool import Tool
from pickcli.geometry import Array
from pickcli.simulation.bellows import SOLID_DEPTH


def write_urdf(robot: Robot, folder: Path) -> Path:
    """Write the robot for the engine, with the cup cut off at the end of the compressed bellows.

    Args:
        robot: The robot.
        folder: Folder for the URDF and its meshes.

    Returns:
        Path of the URDF.
    """
    root = ElementTree.Element("robot", name=robot.name)
    for link in robot.links:
        # The engine uses a base's centre of mass as its frame; this base is fixed, so that does not matter.
        own = link.inertial
        element = add_link(
            root, link.name, replace(own, centre=np.zeros(3)) if link is robot.links[0] else own
        )
        shapes = link.bodies
        if robot.tool.grip.gives_way > 0.0 and link.name == robot.tool.last_link:
            _add_shapes(element, "visual", shapes, folder)  # pictures show the relaxed cup
            shapes = tuple(solid_cup(robot.tool, shapes))
        _add_shapes(element, "collision", shapes, folder)
    for joint in robot.joints:
        add_joint(root, joint)
    path = folder / "robot.urdf"
    ElementTree.indent(root)  # the engine reads lines of at most 8 kB and splits longer ones
    path.write_bytes(ElementTree.tostring(root))
    return path


def solid_cup(tool: Tool, shapes: tuple[Body, ...]) -> Iterator[Body]:
    """Cut the shapes of the cup's link off at the end of the compressed bellows.

    Upright cylinders and boxes are shortened; other shapes that extend further are replaced by their upright
    bounding boxes.

    Args:
        tool: The tool.
        shapes: Shapes of the cup's link.

    Yields:
        The remaining shapes.
    """
    end = float(tool.T_last_tip[2, 3]) - tool.grip.gives_way - SOLID_DEPTH
    for body in shapes:
        T = body.T_parent_shape
        half = body.shape.reach(T[:3, :3])
        low = float(T[2, 3]) - float(half[2])
        if float(T[2, 3]) + float(half[2]) <= end:
            yield body
        elif low < end:
            yield _cut(body, half, low, end - low)


def _cut(body: Body, half: Array, low: float, length: float) -> Body:
    T = np.eye(4)
    T[:3, 3] = *body.T_parent_shape[:2, 3], low + length / 2
    is_upright = abs(body.T_parent_shape[2, 2]) > 1.0 - 1e-9
    if body.shape.kind is ShapeKind.CYLINDER and is_upright:
        return replace(body, shape=Shape(ShapeKind.CYLINDER, (body.shape.size[0], length)), T_parent_shape=T)
    size = (2 * float(half[0]), 2 * float(half[1]), length)
    return replace(body, shape=Shape(ShapeKind.BOX, size), T_parent_shape=T)


def _add_shapes(link: ElementTree.Element, tag: str, shapes: tuple[Body, ...], folder: Path) -> None:
    for body in shapes:
        mesh = ""
        if body.shape.kind is ShapeKind.HULL:
            mesh = f"hull_{len(list(folder.iterdir()))}.obj"
            (folder / mesh).write_text(_obj(body.shape), encoding="ascii")
        add_shape(link, tag, body, mesh)


def _obj(shape: Shape) -> str:
    """Format a hull as OBJ, with outward-facing triangles."""
    corners = np.array(shape.vertices)
    hull = ConvexHull(corners)
    lines = [f"v {spaced(corner)}" for corner in corners.tolist()]
    for triangle, plane in zip(hull.simplices, hull.equations, strict=True):
        a, b, c = corners[triangle]
        is_outwards = np.cross(b - a, c - a) @ plane[:3] > 0.0
        lines.append("f " + " ".join(str(k + 1) for k in (triangle if is_outwards else triangle[::-1])))
    return "\n".join(lines) + "\n"
