"""URDF to a tree of links and joints. Nothing that matters is defaulted: what is missing is named.

Read are links with mass and collision shapes (box, cylinder, sphere, mesh) and joints with origin, axis,
limits and what they mimic. Visuals are ignored, but a link that has nothing else is noted; loops and second
roots are refused. All mistakes of a file are told at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np

from pickcli.cell.mesh_names import MeshNames
from pickcli.cell.robot import Joint, JointType, Link
from pickcli.cell.shapes import Body, Shape, ShapeKind, hull
from pickcli.errors import InputError
from pickcli.files.xml_reader import Element, read_xml
from pickcli.geometry import Array, pose, transform_points
from pickcli.meshes.mesh_pieces import mesh_pieces

# Beyond these a figure was written in another unit.
MAX_SIZE = 10.0  # m, of a link, and from a joint to the next
MAX_MASS = 1e4  # kg
MAX_TURN = 12.6  # rad, of a joint either way: two turns
MAX_TRAVEL = 100.0  # m, of a rail
MOST_TOLD = 20  # mistakes in one message

T = TypeVar("T")


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: its position is ``multiplier`` times the other's, plus ``offset``.

    Attributes:
        joint: Name of the joint that leads.
        multiplier: Of its position.
        offset: rad or m.
    """

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True, eq=False)
class Urdf:
    """A robot as a URDF describes it: a tree of links.

    Attributes:
        name: Of the robot.
        root: Name of the link that no joint moves.
        links: By name, in the order of the file.
        joints: By name of the link that each moves, in the order of the file.
        mimics: What a joint follows, by its name.
        unshaped: Lines of the links that are drawn but have no collision shape, by name.
    """

    name: str
    root: str
    links: dict[str, Link]
    joints: dict[str, Joint]
    mimics: dict[str, Mimic]
    unshaped: dict[str, int]

    def way(self, tip: str) -> tuple[Joint, ...]:
        """The joints from the root to a link.

        Args:
            tip: Name of the link.

        Returns:
            The joints, base outwards.
        """
        found: list[Joint] = []
        while tip in self.joints:
            found.append(self.joints[tip])
            tip = found[-1].parent
        return tuple(reversed(found))

    def children(self, link: str) -> tuple[Joint, ...]:
        """The joints that hang on a link.

        Args:
            link: Name of the link.

        Returns:
            The joints, in the order of the file.
        """
        return tuple(joint for joint in self.joints.values() if joint.parent == link)


def read_urdf(path: Path, folder: Path | None = None, packages: Mapping[str, Path] | None = None) -> Urdf:
    """Read a URDF file.

    Args:
        path: The file.
        folder: Where meshes that are named by a path must lie, besides the packages: the file's own unless
            stated.
        packages: Folders by the name that ``package://`` calls them.

    Returns:
        The robot.

    Raises:
        InputError: Naming file, line and element of everything that is missing or refused.
    """
    robot = read_xml(path)
    if robot.tag != "robot":
        raise robot.error("expected <robot> as the outermost element")
    mistakes = _Mistakes(path)
    meshes = MeshNames(path, path.parent if folder is None else folder, packages or {})
    link_elements = _by_name(robot, "link", mistakes)
    joint_elements = _by_name(robot, "joint", mistakes)
    links = {name: _link(element, meshes, mistakes) for name, element in link_elements.items()}
    joints = {name: _joint(element, mistakes) for name, element in joint_elements.items()}
    mimics = dict(_mimics(joint_elements, mistakes))
    mistakes.check()
    for name, joint in joints.items():
        _check_links(joint_elements[name], joint, links, mistakes)
    mistakes.check()
    by_child: dict[str, Joint] = {}
    for joint in joints.values():
        if joint.child in by_child:
            mistakes.note(
                joint_elements[joint.name].error(
                    f"link {joint.child!r} has a second parent; that closes a loop"
                )
            )
        by_child.setdefault(joint.child, joint)
    mistakes.check()
    return Urdf(
        name=robot.text("name"),
        root=_root(robot, link_elements, joint_elements, by_child),
        links=links,
        joints=by_child,
        mimics=mimics,
        unshaped={
            name: element.line
            for name, element in link_elements.items()
            if element.all("visual") and not links[name].shapes
        },
    )


@dataclass(eq=False)
class _Mistakes:
    """What is wrong with a URDF, in the order in which it was found."""

    path: Path
    found: list[str] = field(default_factory=list)

    def note(self, error: InputError) -> None:
        """Keep a mistake."""
        self.found.append(str(error))

    def tried(self, read: Callable[[], T], otherwise: T) -> T:
        """What ``read`` returns; a mistake is noted, and something else taken so that reading goes on."""
        try:
            return read()
        except InputError as error:
            self.note(error)
            return otherwise

    def check(self) -> None:
        """Raise all of them, in the order of the file, if there are any."""
        if self.found:
            lines = sorted(dict.fromkeys(self.found), key=self._line)
            more = len(lines) - MOST_TOLD
            told = lines[:MOST_TOLD] + [f"{self.path}: and {more} more"] * (more > 0)
            raise InputError("\n".join(told))

    def _line(self, text: str) -> int:
        return int(text.removeprefix(f"{self.path}:").partition(":")[0])


def _by_name(robot: Element, tag: str, mistakes: _Mistakes) -> dict[str, Element]:
    found: dict[str, Element] = {}
    for element in robot.all(tag):
        name = mistakes.tried(partial(element.text, "name"), "")
        if name in found:
            mistakes.note(element.error(f"the name stands in line {found[name].line} too; rename one"))
        elif name:
            found[name] = element
    if not robot.all(tag):
        mistakes.note(robot.error(f"has no <{tag}>; add them"))
    return found


def _link(element: Element, meshes: MeshNames, mistakes: _Mistakes) -> Link:
    name = element.text("name")
    bodies: list[Body] = []
    for i, collision in enumerate(element.all("collision")):
        bodies += mistakes.tried(partial(_bodies, collision, f"{name}_{i}", meshes), [])
    return Link(name, tuple(bodies), mistakes.tried(lambda: _mass(element), 0.0))


def _mass(link: Element) -> float:
    """kg; none stated, or 0, is none."""
    inertial = link.optional("inertial")
    if inertial is None:
        return 0.0
    element = inertial.one("mass")
    mass = element.number("value")
    if mass < 0.0:
        raise element.error(f"expected a mass of 0 kg or more, got {mass:g}")
    if mass > MAX_MASS:
        raise element.error(f"expected a mass of at most {MAX_MASS:g} kg, got {mass:g}")
    return mass


def _bodies(collision: Element, default_name: str, meshes: MeshNames) -> list[Body]:
    """One body, or of a mesh its convex pieces, which share a name."""
    name = collision.attributes.get("name", default_name)
    geometry, T_link_shape = collision.one("geometry"), _origin(collision)
    if len(geometry.children) != 1:
        raise geometry.error("expected exactly one shape")
    element = geometry.children[0]
    if element.tag != "mesh":
        return [Body(name, _shape(element), T_link_shape)]
    path = meshes.find(element)
    scale = element.numbers("scale", 3) if "scale" in element.attributes else (1.0, 1.0, 1.0)
    if not all(scale):
        raise element.error(f"expected factors other than 0 as scale, got {' '.join(map(str, scale))}")
    try:
        pieces = mesh_pieces(path, scale)
    except InputError as error:
        raise element.error(str(error)) from None
    return [hull(name, transform_points(T_link_shape, piece)) for piece in pieces]


def _shape(element: Element) -> Shape:
    if element.tag == "box":
        size = element.numbers("size", 3)
    elif element.tag == "cylinder":
        size = (element.number("radius"), element.number("length"))
    elif element.tag == "sphere":
        size = (element.number("radius"),)
    else:
        raise element.error("expected box, cylinder, sphere or mesh; enclose the part in those")
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


def _joint(element: Element, mistakes: _Mistakes) -> Joint:
    kind = mistakes.tried(lambda: _kind(element), JointType.FIXED)
    lower, upper = mistakes.tried(lambda: _limits(element, kind), (0.0, 0.0))
    return Joint(
        name=element.text("name"),
        type=kind,
        parent=mistakes.tried(lambda: element.one("parent").text("link"), ""),
        child=mistakes.tried(lambda: element.one("child").text("link"), ""),
        T_parent_joint=mistakes.tried(lambda: _origin(element), np.eye(4)),
        axis=mistakes.tried(lambda: _axis(element, kind), np.zeros(3)),
        lower=lower,
        upper=upper,
    )


def _kind(element: Element) -> JointType:
    kinds = sorted(kind.value for kind in JointType)
    if element.text("type") not in kinds:
        raise element.error(f"expected type {', '.join(kinds)}, got {element.text('type')!r}")
    return JointType(element.text("type"))


def _mimics(elements: dict[str, Element], mistakes: _Mistakes) -> Iterator[tuple[str, Mimic]]:
    """Joints that follow another. What a fixed joint mimics means nothing."""
    for name, element in elements.items():
        if element.attributes.get("type") != JointType.FIXED:
            found = mistakes.tried(partial(_mimic, element, elements), None)
            if found is not None:
                yield name, found


def _mimic(joint: Element, elements: dict[str, Element]) -> Mimic | None:
    mimic = joint.optional("mimic")
    if mimic is None:
        return None
    leader = mimic.text("joint")
    if leader not in elements:
        raise mimic.error(f"no joint is named {leader!r}; add it or correct the name")
    if elements[leader].optional("mimic") is not None:
        raise mimic.error(f"{leader!r} mimics a joint itself; name the one that leads")
    factor = mimic.number("multiplier") if "multiplier" in mimic.attributes else 1.0
    return Mimic(leader, factor, mimic.number("offset") if "offset" in mimic.attributes else 0.0)


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
        return -math.pi, math.pi  # the window that is planned in: every direction once
    limit = element.one("limit")
    lower, upper = limit.number("lower"), limit.number("upper")
    if lower >= upper:
        raise limit.error(f"expected lower under upper, got {lower:g} and {upper:g}")
    most, unit = (MAX_TRAVEL, "m, not mm") if kind is JointType.PRISMATIC else (MAX_TURN, "rad, not degrees")
    if max(-lower, upper) > most:
        raise limit.error(f"expected within {most:g} of 0, got {lower:g} and {upper:g}; limits are in {unit}")
    return lower, upper


def _check_links(element: Element, joint: Joint, links: dict[str, Link], mistakes: _Mistakes) -> None:
    for role, name in (("parent", joint.parent), ("child", joint.child)):
        if name not in links:
            mistakes.note(element.one(role).error(f"no link is named {name!r}; add it or correct the name"))


def _root(
    robot: Element, links: dict[str, Element], elements: dict[str, Element], by_child: dict[str, Joint]
) -> str:
    """Name of the root link. Raises InputError unless all links hang on it."""
    roots = [name for name in links if name not in by_child]
    if not roots:
        raise robot.error("has no root: its joints form a loop; remove one")
    if len(roots) > 1:
        raise links[roots[1]].error(f"is a second root beside {roots[0]!r}; connect it by a joint")
    reached, ahead = set(roots), list(roots)
    while ahead:
        link = ahead.pop()
        ahead += [joint.child for joint in by_child.values() if joint.parent == link]
        reached.update(ahead)
    stray = next((joint for joint in by_child.values() if joint.child not in reached), None)
    if stray is not None:
        raise elements[stray.name].error("is part of a loop that the root does not reach; remove it")
    return roots[0]
