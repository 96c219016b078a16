"""Writes links, shapes and joints of a robot as URDF elements."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np

from pickcli.cell.inertial import Inertial
from pickcli.cell.robot import Joint, JointType
from pickcli.cell.shapes import Body, ShapeKind
from pickcli.geometry import Array, pose, to_rpy

_DIGITS = 12  # of angles, enough to reproduce the angles of the file that was read


def add_link(root: ElementTree.Element, name: str, inertial: Inertial) -> ElementTree.Element:
    """Add a link without shapes.

    Args:
        root: The robot's element.
        name: Name of the link.
        inertial: Its mass properties, in its frame.

    Returns:
        The link's element.
    """
    element = ElementTree.SubElement(root, "link", name=name)
    of_link = ElementTree.SubElement(element, "inertial")
    _add_origin(of_link, pose(inertial.centre))
    ElementTree.SubElement(of_link, "mass", value=repr(float(inertial.mass)))
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertial.inertia.tolist()
    moments = {"ixx": xx, "ixy": xy, "ixz": xz, "iyy": yy, "iyz": yz, "izz": zz}
    ElementTree.SubElement(of_link, "inertia", {name: repr(value) for name, value in moments.items()})
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
