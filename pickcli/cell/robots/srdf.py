"""Reads SRDF files: groups, group states, end effectors and disabled collision pairs of a robot."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pickcli.files.file_kind import SRDF
from pickcli.files.xml_reader import Element, read_xml


@dataclass(frozen=True)
class Group:
    """A planning group: union of joints, links, chains and other groups.

    Attributes:
        joints: Names of joints.
        links: Names of links, each standing for its parent joint.
        chains: Pairs of a base link and a tip link.
        groups: Names of other groups.
    """

    joints: tuple[str, ...]
    links: tuple[str, ...]
    chains: tuple[tuple[str, str], ...]
    groups: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class GroupState:
    """A named posture of a group.

    Attributes:
        name: Name of the posture.
        group: Name of the group; empty if the file states none.
        positions: rad or m, by joint.
    """

    name: str
    group: str
    positions: dict[str, float]


@dataclass(frozen=True)
class EndEffector:
    """An end effector of a robot.

    Attributes:
        name: Name of the end effector.
        group: Name of the group of its links.
        parent_link: The link that it is attached to.
    """

    name: str
    group: str
    parent_link: str


@dataclass(frozen=True)
class DisabledPair:
    """Two links that are exempt from collision checks against each other.

    Attributes:
        a: Name of one link.
        b: Name of the other.
        reason: As stated in the file.
        line: Of the file, from 1.
    """

    a: str
    b: str
    reason: str
    line: int


@dataclass(frozen=True, eq=False)
class Srdf:
    """Content of an SRDF.

    Attributes:
        groups: Groups by name.
        states: In the order of the file.
        end_effectors: In the order of the file.
        disabled: In the order of the file.
    """

    groups: dict[str, Group]
    states: tuple[GroupState, ...]
    end_effectors: tuple[EndEffector, ...]
    disabled: tuple[DisabledPair, ...]


def read_srdf(path: Path) -> Srdf:
    """Read an SRDF file; elements that are not used here, e.g. virtual joints, are ignored.

    Args:
        path: The file.

    Returns:
        Its content.

    Raises:
        InputError: Something is missing: with file, line and element.
    """
    robot = read_xml(path, SRDF)
    if robot.tag != "robot":
        raise robot.error("expected <robot> as the outermost element")
    return Srdf(
        groups={element.text("name"): _group(element) for element in robot.all("group")},
        states=tuple(_state(element) for element in robot.all("group_state")),
        end_effectors=tuple(
            EndEffector(e.text("name"), e.text("group"), e.text("parent_link"))
            for e in robot.all("end_effector")
        ),
        disabled=tuple(
            DisabledPair(
                e.text("link1"), e.text("link2"), e.attributes.get("reason", "no reason stated"), e.line
            )
            for e in robot.all("disable_collisions")
        ),
    )


def _group(element: Element) -> Group:
    return Group(
        joints=tuple(e.text("name") for e in element.all("joint")),
        links=tuple(e.text("name") for e in element.all("link")),
        chains=tuple((e.text("base_link"), e.text("tip_link")) for e in element.all("chain")),
        groups=tuple(e.text("name") for e in element.all("group")),
    )


def _state(element: Element) -> GroupState:
    positions = {e.text("name"): e.number("value") for e in element.all("joint")}
    return GroupState(element.text("name"), element.attributes.get("group", ""), positions)
