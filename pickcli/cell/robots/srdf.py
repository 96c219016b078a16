"""SRDF files: what MoveIt's users say about a robot besides its URDF."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pickcli.files.file_kind import SRDF
from pickcli.files.xml_reader import Element, read_xml


@dataclass(frozen=True)
class Group:
    """A planning group: joints, links, chains and other groups together.

    Attributes:
        joints: Names of joints.
        links: Names of links, each for the joint that moves it.
        chains: Pairs of a base link and a tip link.
        groups: Names of other groups.
    """

    joints: tuple[str, ...]
    links: tuple[str, ...]
    chains: tuple[tuple[str, str], ...]
    groups: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class GroupState:
    """A posture of a group with a name.

    Attributes:
        name: Of the posture.
        group: Name of the group; empty where the file states none.
        positions: rad or m, by joint.
    """

    name: str
    group: str
    positions: dict[str, float]


@dataclass(frozen=True)
class EndEffector:
    """What a group carries.

    Attributes:
        name: Of the end effector.
        group: Name of the group of its own links.
        parent_link: The link that carries it.
    """

    name: str
    group: str
    parent_link: str


@dataclass(frozen=True)
class DisabledPair:
    """Two links that are never tested against each other.

    Attributes:
        a: Name of one link.
        b: Name of the other.
        reason: In the words of the file.
    """

    a: str
    b: str
    reason: str


@dataclass(frozen=True, eq=False)
class Srdf:
    """What an SRDF says.

    Attributes:
        groups: By name.
        states: In the order of the file.
        end_effectors: In the order of the file.
        disabled: In the order of the file.
    """

    groups: dict[str, Group]
    states: tuple[GroupState, ...]
    end_effectors: tuple[EndEffector, ...]
    disabled: tuple[DisabledPair, ...]


def read_srdf(path: Path) -> Srdf:
    """Read an SRDF file. What planning here has no use for, e.g. virtual joints, is left out.

    Args:
        path: The file.

    Returns:
        Its content.

    Raises:
        InputError: Naming file, line and element of what is missing.
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
            DisabledPair(e.text("link1"), e.text("link2"), e.attributes.get("reason", "no reason stated"))
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
