"""What stands in a page: robot, solids, items, named points and paths. See ``page_document``."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any, TypeAlias

import numpy as np

from pickcli.geometry import Array, to_quaternion

Pose: TypeAlias = tuple[float, ...]
Packed: TypeAlias = dict[str, Any]

_DIGITS = 6  # of metres and of quaternions: a micrometre


class Tone(StrEnum):
    """How a line of text is meant."""

    PLAIN = ""
    GOOD = "good"
    FAIR = "fair"
    BAD = "bad"


@dataclass(frozen=True)
class Fact:
    """One row of the panel.

    Attributes:
        label: What it is of.
        value: What is so.
        tone: How that is meant.
    """

    label: str
    value: str
    tone: Tone = Tone.PLAIN


@dataclass(frozen=True, eq=False)
class PageShape:
    """A solid, or a mesh.

    Attributes:
        kind: "box", "cylinder" (along z), "sphere" or "mesh".
        size: m: box full extents; cylinder radius and length; sphere radius; of a mesh nothing.
        corners: Of a mesh its corners (V, 3), m.
        triangles: Of a mesh the indices (F, 3) of its triangles.
        colour: As #rrggbb; "" for that of what it is part of.
        is_smooth: Whether the edges between flat triangles are rounded off in the light.
    """

    kind: str
    size: tuple[float, ...] = ()
    corners: Packed | None = None
    triangles: Packed | None = None
    colour: str = ""
    is_smooth: bool = False


@dataclass(frozen=True, eq=False)
class PageBody:
    """A named shape in the frame of what it is part of.

    Attributes:
        name: Its own.
        shape: The shape.
        pose: In the frame of its owner.
    """

    name: str
    shape: PageShape
    pose: Pose


@dataclass(frozen=True, eq=False)
class PageLink:
    """One rigid link.

    Attributes:
        name: Its own.
        bodies: What it looks like.
        is_tool: Whether it is of the tool, through which one never looks.
    """

    name: str
    bodies: tuple[PageBody, ...]
    is_tool: bool = False


@dataclass(frozen=True, eq=False)
class PageJoint:
    """A joint between two links.

    Attributes:
        name: Its own.
        type: As in a URDF.
        parent: Index of the link that it is fixed to.
        child: Index of the link that it moves.
        pose: Of the joint frame in the parent, at position 0.
        axis: Unit axis in the joint frame.
    """

    name: str
    type: str
    parent: int
    child: int
    pose: Pose
    axis: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class PageRobot:
    """The robot, with where it stands while nothing moves.

    Attributes:
        name: Its own.
        pose: Of the root link in the world.
        links: The root first.
        joints: The base first.
        moved: Names of the joints that a motion moves, in the order of its columns.
        start: Their positions, rad or m, while there is no motion.
        tip_link: Index of the link that the tool frame is fixed to.
        tip: Pose of the tool frame in that link.
    """

    name: str
    pose: Pose
    links: tuple[PageLink, ...]
    joints: tuple[PageJoint, ...]
    moved: tuple[str, ...]
    start: tuple[float, ...]
    tip_link: int
    tip: Pose


@dataclass(frozen=True, eq=False)
class PageGroup:
    """What stands in the cell and belongs together.

    Attributes:
        name: Of the carrier, or "obstacle".
        pose: In the world.
        colour: As #rrggbb.
        bodies: Its solids.
        opacity: Of its solids while one looks through them: in (0, 1].
    """

    name: str
    pose: Pose
    colour: str
    bodies: tuple[PageBody, ...]
    opacity: float = 1.0


@dataclass(frozen=True, eq=False)
class PagePlace:
    """A place that can be looked into.

    Attributes:
        name: Its own.
        mouth: Pose of its mouth in the world, x leading in.
        size: m, width along the mouth's y and height along its z.
    """

    name: str
    mouth: Pose
    size: tuple[float, float]


@dataclass(frozen=True, eq=False)
class PageItem:
    """One item as a page shows it.

    Attributes:
        id: In the scene.
        name: What is printed on it.
        colour: As #rrggbb.
        shape: Its shape.
        pose: In the world, at the start.
        facts: What is told of it when it is clicked on.
    """

    id: str
    name: str
    colour: str
    shape: PageShape
    pose: Pose
    facts: tuple[Fact, ...] = ()


@dataclass(frozen=True, eq=False)
class PageNode:
    """A named point.

    Attributes:
        name: Its own; "" for one without a label.
        point: (3,) m in the world.
        colour: As #rrggbb.
        is_main: Whether its label is always shown.
    """

    name: str
    point: tuple[float, ...]
    colour: str
    is_main: bool = True


@dataclass(frozen=True, eq=False)
class PageLine:
    """A path of the tool, without time.

    Attributes:
        name: Its own.
        points: (N, 3) m in the world.
        colour: As #rrggbb.
    """

    name: str
    points: Packed
    colour: str


def posed(T: Array) -> Pose:
    """Turn a pose into the numbers that a page holds.

    Args:
        T: (4, 4).

    Returns:
        x, y, z in m, and the quaternion x, y, z, w.
    """
    return rounded((*T[:3, 3].tolist(), *to_quaternion(T[:3, :3]).tolist()))


def rounded(values: tuple[float, ...] | Array) -> tuple[float, ...]:
    """Numbers to a micrometre, without a negative zero.

    Args:
        values: (k,) numbers.

    Returns:
        The numbers.
    """
    return tuple(round(float(value), _DIGITS) + 0.0 for value in np.asarray(values))
