"""Static data of a page: robot, solids, items, named points and paths. See ``page_document``."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any, TypeAlias

import numpy as np

from pickcli.geometry import Array, to_quaternion

Pose: TypeAlias = tuple[float, ...]
Packed: TypeAlias = dict[str, Any]

_DIGITS = 6  # decimals of metres and quaternions


class Tone(StrEnum):
    """Tone of a line of text."""

    PLAIN = ""
    GOOD = "good"
    FAIR = "fair"
    BAD = "bad"


@dataclass(frozen=True)
class Fact:
    """One row of the panel.

    Attributes:
        label: Name of the value.
        value: The value.
        tone: Tone of the row.
    """

    label: str
    value: str
    tone: Tone = Tone.PLAIN


@dataclass(frozen=True, eq=False)
class PageShape:
    """A solid, or a mesh.

    Attributes:
        kind: "box", "cylinder" (along z), "sphere" or "mesh".
        size: m: box full extents; cylinder radius and length; sphere radius; empty for a mesh.
        corners: Corners (V, 3) of a mesh, m.
        triangles: Indices (F, 3) of a mesh's triangles.
        colour: As #rrggbb; "" for the colour of its owner.
        is_smooth: Whether edges between triangles are shaded smoothly.
    """

    kind: str
    size: tuple[float, ...] = ()
    corners: Packed | None = None
    triangles: Packed | None = None
    colour: str = ""
    is_smooth: bool = False


@dataclass(frozen=True, eq=False)
class PageBody:
    """A named shape in the frame of its owner.

    Attributes:
        name: Name of the body.
        shape: The shape.
        pose: Pose in the frame of its owner.
    """

    name: str
    shape: PageShape
    pose: Pose


@dataclass(frozen=True, eq=False)
class PageLink:
    """One rigid link.

    Attributes:
        name: Name of the link.
        bodies: Its visible bodies.
        is_tool: Whether it is part of the tool, which is never drawn transparent.
    """

    name: str
    bodies: tuple[PageBody, ...]
    is_tool: bool = False


@dataclass(frozen=True, eq=False)
class PageJoint:
    """A joint between two links.

    Attributes:
        name: Name of the joint.
        type: As in a URDF.
        parent: Index of the parent link.
        child: Index of the child link.
        pose: Pose of the joint frame in the parent, at position 0.
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
    """The robot, with its configuration at rest.

    Attributes:
        name: Name of the robot.
        pose: Pose of the root link in the world.
        links: Links, the root first.
        joints: Joints, the base first.
        moved: Names of the moving joints, in the order of a motion's columns.
        start: Their positions without motion, rad or m.
        tip_link: Index of the link to which the tool frame is fixed.
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


# Pages are shown in 3-D only with a robot; this one is invisible.
INVISIBLE_ROBOT = PageRobot(
    "", (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0), (PageLink("world", ()),), (), (), (), 0,
    (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class PageGroup:
    """Static bodies of one carrier, or the obstacles.

    Attributes:
        name: Name of the carrier, or "obstacle".
        pose: Pose in the world.
        colour: As #rrggbb.
        bodies: Its solids.
        opacity: Opacity of its solids when drawn transparent, in (0, 1].
    """

    name: str
    pose: Pose
    colour: str
    bodies: tuple[PageBody, ...]
    opacity: float = 1.0


@dataclass(frozen=True, eq=False)
class PagePlace:
    """A place with its mouth.

    Attributes:
        name: Name of the place.
        mouth: Pose of its mouth in the world, with x into the place.
        size: m, width along the mouth's y and height along its z.
    """

    name: str
    mouth: Pose
    size: tuple[float, float]


@dataclass(frozen=True, eq=False)
class PageItem:
    """An item on a page.

    Attributes:
        id: Id in the scene.
        name: Label.
        colour: As #rrggbb.
        shape: Its shape.
        pose: Pose in the world at the start.
        facts: Facts shown when it is clicked.
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
        name: Label; "" without one.
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
        name: Name of the path.
        points: (N, 3) m in the world.
        colour: As #rrggbb.
    """

    name: str
    points: Packed
    colour: str


def posed(T: Array) -> Pose:
    """Convert a pose to the numbers in a page.

    Args:
        T: (4, 4).

    Returns:
        x, y, z in m, and the quaternion x, y, z, w.
    """
    return rounded((*T[:3, 3].tolist(), *to_quaternion(T[:3, :3]).tolist()))


def rounded(values: tuple[float, ...] | Array) -> tuple[float, ...]:
    """Round numbers to six decimals, without negative zeros.

    Args:
        values: (k,) numbers.

    Returns:
        The numbers.
    """
    return tuple(round(float(value), _DIGITS) + 0.0 for value in np.asarray(values))
