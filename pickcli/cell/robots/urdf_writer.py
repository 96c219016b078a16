"""Writes links, shapes and joints of a robot as URDF elements."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np

from pickcli.cell.robot import Joint, JointType, Link
from pickcli.cell.shapes import Body, ShapeKind
from pickcli.geometry import Array, to_rpy

DENSITY = 1000.0  # kg/m^3, assumed for links without a mass, over the boxes around their shapes
LEAST_MASS = 1e-3  # kg; physics engines divide by masses
_DIGITS = 12  # of angles, enough to reproduce the angles of the file that was read


def add_link(root: ElementTree.Element, link: Link, T_link_inertia: Array) -> ElementTree.Element:
    """Add a link without shapes.

    Args:
        root: The robot's element.
        link: The link.
        T_link_inertia: (4, 4) pose of the frame in its centre of mass.

    Returns:
        The link's element.
    """
    element = ElementTree.SubElement(root, "link", name=link.name)
    inertial = ElementTree.SubElement(element, "inertial")
    _add_origin(inertial, T_link_inertia)
    volume = sum(float(np.prod(body.shape.extents)) for body in link.bodies)
    mass = link.mass or max(LEAST_MASS, DENSITY * volume)
    ElementTree.SubElement(inertial, "mass", value=repr(mass))
    # Readers require an inertia but do not use it: they compute it from mass and shapes.
    zeros = dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), "0")
    ElementTree.SubElement(inertial, "inertia", zeros)
    return element


def add_shape(link: ElementTree.Element, tag: str, body: Body, mesh: str = "") -> None:
    """Add a shape to a link.

    Args:
        link: The link's element.
        tag: "visual" or "collision".
        body: The shape, in the link frame.
        mesh: Name of the mesh file of a hull.
    """
    element = ElementTree.SubElement(link, tag, name=body.name)
    _add_origin(element, body.T_parent_shape)
    geometry, size = ElementTree.SubElement(element, "geometry"), body.shape.size
    if body.shape.kind is ShapeKind.BOX:
        ElementTree.SubElement(geometry, "box", size=spaced(size))
    elif body.shape.kind is ShapeKind.CYLINDER:
        ElementTree.SubElement(geometry, "cylinder", radius=repr(size[0]), length=repr(size[1]))
    elif body.shape.kind is ShapeKind.SPHERE:
        ElementTree.SubElement(geometry, "sphere", radius=repr(size[0]))
    else:
        ElementTree.SubElement(geometry, "mesh", filename=mesh)


def add_joint(root: ElementTree.Element, joint: Joint) -> None:
    """Add a joint. Its effort and velocity limits are written as 0, as they are stated elsewhere.

    Args:
        root: The robot's element.
        joint: The joint.
    """
    element = ElementTree.SubElement(root, "joint", name=joint.name, type=joint.type.value)
    ElementTree.SubElement(element, "parent", link=joint.parent)
    ElementTree.SubElement(element, "child", link=joint.child)
    _add_origin(element, joint.T_parent_joint)
    if joint.type is not JointType.FIXED:
        ElementTree.SubElement(element, "axis", xyz=spaced(joint.axis.tolist()))
        limit = ElementTree.SubElement(element, "limit", effort="0", velocity="0")
        if joint.type is not JointType.CONTINUOUS:
            limit.attrib.update(lower=repr(joint.lower), upper=repr(joint.upper))


def spaced(numbers: tuple[float, ...] | list[float]) -> str:
    """Format numbers as in URDF.

    Args:
        numbers: The numbers.

    Returns:
        The numbers with all their digits, separated by blanks.
    """
    return " ".join(map(repr, numbers))


def _add_origin(element: ElementTree.Element, T: Array) -> None:
    rpy = np.round(to_rpy(T[:3, :3]), _DIGITS).tolist()
    ElementTree.SubElement(element, "origin", xyz=spaced(T[:3, 3].tolist()), rpy=spaced(rpy))
