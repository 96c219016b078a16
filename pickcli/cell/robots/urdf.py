"""Reads a URDF into a tree of links and joints. Missing values are reported, not defaulted.

Links are read with mass and collision shapes (box, cylinder, sphere, mesh: `urdf_link`), joints with origin,
axis, limits and mimics (`urdf_joint`). Visuals are ignored, but links with visuals and without collision
shapes are listed. Loops and second roots are refused. All mistakes of a file are reported at once.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from pickcli.cell.robot import Joint, JointType, Link
from pickcli.cell.robots.mesh_names import MeshNames
from pickcli.cell.robots.urdf_joint import Mimic, read_joint, read_mimics
from pickcli.cell.robots.urdf_link import read_link
from pickcli.files.xml_mistakes import XmlMistakes
from pickcli.files.xml_reader import Element, read_xml


@dataclass(frozen=True, eq=False)
class Urdf:
    """A robot as described by a URDF: a tree of links.

    Attributes:
        name: Name of the robot.
        root: Name of the root link.
        links: By name, in the order of the file.
        joints: By name of the child link, in the order of the file.
        mimics: Mimic relations by name of the following joint.
        unshaped: Line numbers of the links that have visuals but no collision shape, by name.
    """

    name: str
    root: str
    links: dict[str, Link]
    joints: dict[str, Joint]
    mimics: dict[str, Mimic]
    unshaped: dict[str, int]

    def way(self, tip: str) -> tuple[Joint, ...]:
        """Return the joints from the root to a link.

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
        """Return the joints whose parent is a link.

        Args:
            link: Name of the link.

        Returns:
            The joints, in the order of the file.
        """
        return tuple(joint for joint in self.joints.values() if joint.parent == link)

    def driven(self, joints: Iterable[Joint]) -> dict[str, Joint]:
        """Return the joints that are neither fixed nor mimics.

        Args:
            joints: Joints of this robot.

        Returns:
            The joints by name, in the order given.
        """
        return {j.name: j for j in joints if j.type is not JointType.FIXED and j.name not in self.mimics}


def read_urdf(path: Path, folder: Path | None = None, packages: Mapping[str, Path] | None = None) -> Urdf:
    """Read a URDF file.

    Args:
        path: The file.
        folder: Folder that must contain meshes named by a path, unless a package does; by default the
            folder of the file.
        packages: Folders of the packages, by name as in ``package://``.

    Returns:
        The robot.

    Raises:
        InputError: With file, line and element of everything that is missing or refused.
    """
    robot = read_xml(path)
    if robot.tag != "robot":
        raise robot.error("expected <robot> as the outermost element")
    for element in robot.children:
        if element.tag.startswith("xacro:"):
            raise element.error("not expanded; run xacro on it, or give it to apc init --urdf")
    mistakes = XmlMistakes(path)
    meshes = MeshNames(path, path.parent if folder is None else folder, packages or {})
    link_elements = _by_name(robot, "link", mistakes)
    joint_elements = _by_name(robot, "joint", mistakes)
    links = {name: read_link(element, meshes, mistakes) for name, element in link_elements.items()}
    joints = {name: read_joint(element, mistakes) for name, element in joint_elements.items()}
    mimics = dict(read_mimics(joint_elements, mistakes))
    mistakes.check()
    for name, joint in joints.items():
        _check_links(joint_elements[name], joint, links, mistakes)
    mistakes.check()
    by_child = _by_child(joints, joint_elements, mistakes)
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
            if element.all("visual") and not links[name].bodies
        },
    )


def _by_name(robot: Element, tag: str, mistakes: XmlMistakes) -> dict[str, Element]:
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


def _by_child(
    joints: dict[str, Joint], elements: dict[str, Element], mistakes: XmlMistakes
) -> dict[str, Joint]:
    """The joints by child link; a link with two parent joints is a mistake."""
    found: dict[str, Joint] = {}
    for joint in joints.values():
        if joint.child in found:
            text = f"link {joint.child!r} has a second parent; that closes a loop"
            mistakes.note(elements[joint.name].error(text))
        found.setdefault(joint.child, joint)
    return found


def _check_links(element: Element, joint: Joint, links: dict[str, Link], mistakes: XmlMistakes) -> None:
    for role, name in (("parent", joint.parent), ("child", joint.child)):
        if name not in links:
            mistakes.note(element.one(role).error(f"no link is named {name!r}; add it or correct the name"))


def _root(
    robot: Element, links: dict[str, Element], elements: dict[str, Element], by_child: dict[str, Joint]
) -> str:
    """Return the root link's name. Raise InputError unless all links are connected to it."""
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
