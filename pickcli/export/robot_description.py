"""Writes a robot as URDF in a single text, as published on a topic, without mesh files."""

from __future__ import annotations

from dataclasses import replace
from xml.etree import ElementTree

from pickcli.cell.robot import Robot
from pickcli.cell.robots.urdf_writer import add_joint, add_link, add_shape
from pickcli.cell.shapes import Body, Shape, ShapeKind


def robot_description(robot: Robot) -> str:
    """Write a robot as known to the planner and the verifier.

    Args:
        robot: The robot.

    Returns:
        URDF with collision shapes as visuals; convex pieces of meshes are replaced by their bounding boxes.
    """
    root = ElementTree.Element("robot", name=robot.name)
    for link in robot.links:
        element = add_link(root, link.name, link.inertial)
        for body in link.bodies:
            for tag in ("visual", "collision"):
                add_shape(element, tag, _boxed(body))
    for joint in robot.joints:
        add_joint(root, joint)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode")


def _boxed(body: Body) -> Body:
    if body.shape.kind is not ShapeKind.HULL:
        return body
    return replace(body, shape=Shape(ShapeKind.BOX, body.shape.size))
