"""URDF to links and joints of a serial chain. Nothing that matters is defaulted: what is missing is named.

Read are links with mass and collision shapes (box, cylinder, sphere) and joints with origin, axis and
limits. Visuals are ignored; meshes, mimic joints, trees, loops and second roots are refused.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pickcli.cell.robot import Joint, JointType, Link
from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.files.xml_reader import Element, read_xml
from pickcli.geometry import Array, pose

# Beyond these a figure was written in another unit.
MAX_SIZE = 10.0  # m, of a link, and from a joint to the next
MAX_MASS = 1e4  # kg
MAX_TURN = 12.6  # rad, of a joint either way: two turns
MAX_TRAVEL = 100.0  # m, of a rail


@dataclass(frozen=True, eq=False)
class UrdfChain:
    """A serial chain; ``links[i + 1]`` is the child of ``joints[i]``.

    Attributes:
        name: Of the robot.
        links: From the root outwards.
        joints: From the root outwards.
    """

    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]


def read_urdf(path: Path) -> UrdfChain:
    """Read the serial chain in a URDF file.

    Args:
        path: The file.

    Returns:
        The chain.

    Raises:
        InputError: Naming file, line and element of what is missing or refused.
    """
    robot = read_xml(path)
    if robot.tag != "robot":
        raise robot.error("expected <robot> as the outermost element")
    link_elements = _by_name(robot, "link")
    joint_elements = _by_name(robot, "joint")
    links = {name: _link(element) for name, element in link_elements.items()}
    joints = {name: _joint(element) for name, element in joint_elements.items()}
    for name, joint in joints.items():
        _check_links(joint_elements[name], joint, links)
    root, ordered = _in_order(robot, link_elements, joint_elements, joints)
    return UrdfChain(
        name=robot.text("name"),
        links=(links[root], *(links[joint.child] for joint in ordered)),
        joints=tuple(ordered),
    )


def _by_name(robot: Element, tag: str) -> dict[str, Element]:
    found: dict[str, Element] = {}
    for element in robot.all(tag):
        name = element.text("name")
        if name in found:
            raise element.error(f"the name stands in line {found[name].line} too; rename one")
        found[name] = element
    if not found:
        raise robot.error(f"has no <{tag}>; add them")
    return found


def _link(element: Element) -> Link:
    inertial = element.optional("inertial")
    mass = 0.0
    if inertial is not None:
        mass_element = inertial.one("mass")
        mass = mass_element.number("value")
        if mass <= 0.0:
            raise mass_element.error(f"expected a mass over 0 kg, got {mass:g}")
        if mass > MAX_MASS:
            raise mass_element.error(f"expected a mass of at most {MAX_MASS:g} kg, got {mass:g}")
    bodies = [_body(c, f"{element.text('name')}_{i}") for i, c in enumerate(element.all("collision"))]
    return Link(element.text("name"), tuple(bodies), mass)


def _body(collision: Element, default_name: str) -> Body:
    shape = _shape(collision.one("geometry"))
    return Body(collision.attributes.get("name", default_name), shape, _origin(collision))


def _shape(geometry: Element) -> Shape:
    if len(geometry.children) != 1:
        raise geometry.error("expected exactly one shape")
    element = geometry.children[0]
    if element.tag == "box":
        size = element.numbers("size", 3)
    elif element.tag == "cylinder":
        size = (element.number("radius"), element.number("length"))
    elif element.tag == "sphere":
        size = (element.number("radius"),)
    else:
        raise element.error("expected box, cylinder or sphere; enclose the part in those")
    if min(size) <= 0.0:
        raise element.error(f"expected sizes over 0 m, got {' '.join(map(str, size))}")
    if max(size) > MAX_SIZE:
        listed = " ".join(map(str, size))
        raise element.error(
            f"expected sizes of at most {MAX_SIZE:g} m, got {listed}; lengths are in m, not mm"
        )
    return Shape(ShapeKind(element.tag), size)


def _origin(element: Element) -> Array:
    """URDF's origin; leaving it out means none, as the format says."""
    origin = element.optional("origin")
    if origin is None:
        return np.eye(4)
    xyz = origin.numbers("xyz", 3) if "xyz" in origin.attributes else (0.0, 0.0, 0.0)
    rpy = origin.numbers("rpy", 3) if "rpy" in origin.attributes else (0.0, 0.0, 0.0)
    if max(map(abs, xyz)) > MAX_SIZE:
        raise origin.error(f"expected xyz within {MAX_SIZE:g} m, got {xyz}; lengths are in m, not mm")
    if max(map(abs, rpy)) > MAX_TURN:
        raise origin.error(f"expected rpy within {MAX_TURN:g} rad, got {rpy}; angles are in rad, not degrees")
    return pose(xyz, rpy=rpy)


def _joint(element: Element) -> Joint:
    kinds = {kind.value for kind in JointType}
    if element.text("type") not in kinds:
        raise element.error(f"expected type {', '.join(sorted(kinds))}, got {element.text('type')!r}")
    kind = JointType(element.text("type"))
    mimic = element.optional("mimic")
    if mimic is not None:
        raise mimic.error("mimic joints are not supported; replace it by a fixed joint")
    lower, upper = _limits(element, kind)
    return Joint(
        name=element.text("name"),
        type=kind,
        parent=element.one("parent").text("link"),
        child=element.one("child").text("link"),
        T_parent_joint=_origin(element),
        axis=_axis(element, kind),
        lower=lower,
        upper=upper,
    )


def _axis(element: Element, kind: JointType) -> Array:
    if kind is JointType.FIXED:
        return np.array([0.0, 0.0, 1.0])  # moves nothing
    axis_element = element.one("axis")
    axis = np.array(axis_element.numbers("xyz", 3))
    length = math.hypot(*axis)
    if not 1e-6 <= length <= 1e6:
        raise axis_element.error("the axis has no direction; expected a vector of length 1")
    return np.asarray(axis / length)


def _limits(element: Element, kind: JointType) -> tuple[float, float]:
    if kind is JointType.FIXED:
        return 0.0, 0.0
    if kind is JointType.CONTINUOUS:
        return -np.inf, np.inf
    limit = element.one("limit")
    lower, upper = limit.number("lower"), limit.number("upper")
    if lower >= upper:
        raise limit.error(f"expected lower under upper, got {lower:g} and {upper:g}")
    most, unit = (MAX_TRAVEL, "m, not mm") if kind is JointType.PRISMATIC else (MAX_TURN, "rad, not degrees")
    if max(-lower, upper) > most:
        raise limit.error(f"expected within {most:g} of 0, got {lower:g} and {upper:g}; limits are in {unit}")
    return lower, upper


def _check_links(element: Element, joint: Joint, links: dict[str, Link]) -> None:
    for role, name in (("parent", joint.parent), ("child", joint.child)):
        if name not in links:
            raise element.one(role).error(f"no link is named {name!r}; add it or correct the name")


def _in_order(
    robot: Element, links: dict[str, Element], elements: dict[str, Element], joints: dict[str, Joint]
) -> tuple[str, list[Joint]]:
    """Root link and the joints from it outwards. Raises InputError unless they form one serial chain."""
    by_parent: dict[str, Joint] = {}
    by_child: dict[str, Joint] = {}
    for joint in joints.values():
        element = elements[joint.name]
        if joint.child in by_child:
            raise element.error(f"link {joint.child!r} has a second parent; that closes a loop")
        if joint.parent in by_parent:
            first = by_parent[joint.parent].name
            raise element.error(f"link {joint.parent!r} has two children ({first!r} too); a chain has one")
        by_child[joint.child], by_parent[joint.parent] = joint, joint
    roots = [name for name in links if name not in by_child]
    if not roots:
        raise robot.error("has no root: its joints form a loop; remove one")
    if len(roots) > 1:
        raise links[roots[1]].error(f"is a second root beside {roots[0]!r}; connect it by a joint")
    ordered: list[Joint] = []
    link = roots[0]
    while link in by_parent:
        ordered.append(by_parent[link])
        link = ordered[-1].child
    if len(ordered) < len(joints):
        stray = next(joint for joint in joints.values() if joint not in ordered)
        raise elements[stray.name].error("is part of a loop that the root does not reach; remove it")
    return roots[0], ordered
