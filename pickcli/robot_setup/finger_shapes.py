"""Moves shapes of links fixed to a finger onto the finger, as cells support only one link per finger."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from xml.etree import ElementTree

import numpy as np

from pickcli.cell.robot import JointType
from pickcli.cell.robots.urdf import Urdf
from pickcli.geometry import Array, pose, to_rpy

_DRAWN = ("visual", "collision")


def with_whole_fingers(text: str, robot: Urdf, ends: Sequence[str]) -> str:
    """Rewrite a URDF such that shapes of links fixed to a sliding link belong to that link.

    Args:
        text: The URDF, which was read without mistakes.
        robot: The robot read from it.
        ends: Names of the links that the arm's last joint moves and no later joint.

    Returns:
        The URDF; unchanged if no link with a shape is fixed to a sliding one.
    """
    sliding = [j.child for end in ends for j in robot.children(end) if j.type is JointType.PRISMATIC]
    pads = {
        pad: (finger, T_finger_pad)
        for finger in sliding
        for pad, T_finger_pad in _fixed_to(robot, finger)
        if robot.links[pad].bodies
    }
    if not pads:
        return text
    tree = ElementTree.fromstring(
        text, ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True))
    )
    links = {link.get("name"): link for link in tree.findall("link")}
    for pad, (finger, T_finger_pad) in pads.items():
        for drawn in [each for tag in _DRAWN for each in links[pad].findall(tag)]:
            links[pad].remove(drawn)
            _move(drawn, T_finger_pad)
            links[finger].append(drawn)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(tree, encoding="unicode") + "\n"


def _fixed_to(robot: Urdf, link: str) -> Iterator[tuple[str, Array]]:
    """Links that are fixed to a link, directly or indirectly, with their poses (4, 4) in it."""
    for joint in robot.children(link):
        if joint.type is JointType.FIXED:
            yield joint.child, joint.T_parent_joint
            for child, T in _fixed_to(robot, joint.child):
                yield child, joint.T_parent_joint @ T


def _move(drawn: ElementTree.Element, T: Array) -> None:
    """Premultiply the origin of a shape, identity if it has none, by a pose (4, 4)."""
    origin = drawn.find("origin")
    if origin is None:
        origin = ElementTree.Element("origin")
        drawn.insert(0, origin)
    xyz, rpy = (np.array(origin.get(key, "0 0 0").split(), dtype=float) for key in ("xyz", "rpy"))
    moved = T @ pose(xyz, rpy=(float(rpy[0]), float(rpy[1]), float(rpy[2])))
    for key, values in (("xyz", moved[:3, 3]), ("rpy", to_rpy(moved[:3, :3]))):
        origin.set(key, " ".join(f"{value + 0.0:.9g}" for value in values))
