"""Converts static parts of cells and scenes to data of a page."""

from __future__ import annotations

import numpy as np

from pickcli.cell.cell import Cell, NamedConfiguration
from pickcli.cell.item import Item
from pickcli.cell.robot import Link, Robot
from pickcli.cell.shapes import Body
from pickcli.cell.station import OBSTACLE, POD, TOTE, UNKNOWN
from pickcli.cell.tool import ToolState
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.page.page_scene import (
    Fact,
    PageBody,
    PageGroup,
    PageItem,
    PageJoint,
    PageLink,
    PageNode,
    PagePlace,
    PageRobot,
    posed,
    rounded,
)
from pickcli.page.shape_parts import drawn_body, drawn_item
from pickcli.page.visual_meshes import visual_bodies
from pickcli.scene.colours import item_colour, static_colour
from pickcli.scene.scene import PlacedItem, Scene

_NODE_COLOURS = {
    "home": "#8a8f98",
    "bin": "#0072b2",
    "camera": "#cc79a7",
    "tote": "#d55e00",
    "drop": "#d55e00",
}
_OTHER = "#999999"
_LANCE, _CUP = "#4a515c", "#e2762c"
_MAIN = ("home", "bin", "tote")
_OPACITY = {POD: 0.13, OBSTACLE: 0.22, TOTE: 0.6, UNKNOWN: 0.25}
_OF_OWN = 0.35  # of user-defined carriers
_FLOOR = 2.99  # m; bodies larger than this along two axes are floors or walls of the hall


def robot_part(cell: Cell, q: Array | None = None, tool_state: ToolState | None = None) -> PageRobot:
    """Convert the robot, at its configuration at rest.

    Args:
        cell: The cell.
        q: (n,) configuration; None for home, or the first named configuration.
        tool_state: State of the tool; None for that of the configuration.

    Returns:
        The robot.
    """
    robot, rest, looks = cell.robot, rest_configuration(cell), visual_bodies(cell)
    indices = {link.name: i for i, link in enumerate(robot.links)}
    state = tool_state or (robot.tool.default_state if rest is None else rest.tool_state)
    if q is None:
        q = np.zeros(robot.n_joints) if rest is None else rest.q
    tool = robot.tool
    of_tool = {} if tool.is_bare else {tool.lance_link: _LANCE, **dict.fromkeys(tool.contact_links, _CUP)}
    return PageRobot(
        name=robot.name,
        pose=posed(robot.T_world_base),
        links=tuple(
            PageLink(
                link.name,
                looks.get(link.name) or _shapes(link, of_tool.get(link.name, "")),
                link.name in of_tool,
            )
            for link in robot.links
        ),
        joints=tuple(
            PageJoint(
                joint.name, str(joint.type), indices[joint.parent], indices[joint.child],
                posed(joint.T_parent_joint), rounded(joint.axis),
            )
            for joint in robot.joints
        ),
        moved=robot.moving_joints,
        start=rounded(np.append(q, tool_positions(robot, state))),
        tip_link=indices[robot.tool.last_link],
        tip=posed(robot.tool.T_last_tip),
    )  # fmt: skip


def _shapes(link: Link, colour: str) -> tuple[PageBody, ...]:
    """Convert the collision shapes of a link."""
    return tuple(drawn_body(body, colour) for body in link.bodies)


def rest_configuration(cell: Cell) -> NamedConfiguration | None:
    """Return the configuration in which a stationary arm is drawn.

    Args:
        cell: The cell.

    Returns:
        Home, else the first named configuration; None without any.
    """
    named = list(cell.configurations.values())
    return next((each for each in named if each.kind == "home"), named[0] if named else None)


def tool_positions(robot: Robot, state: ToolState) -> Array:
    """Return the positions of the tool's joints in a state.

    Args:
        robot: The robot.
        state: State of the tool.

    Returns:
        (k,) rad or m.
    """
    tool = robot.tool
    return np.array([tool.joint_position(name, state) for name in tool.joints])


def standing_parts(scene: Scene) -> tuple[PageGroup, ...]:
    """Convert carriers and obstacles at their poses.

    Args:
        scene: The scene.

    Returns:
        One group each, without floors and walls of the hall.
    """
    groups = []
    for each in scene.posed_carriers:
        bodies = tuple(drawn_body(body) for body in each.bodies if not _is_floor(body))
        if bodies:
            colour, opacity = _hex(static_colour(each.name)), _OPACITY.get(each.name, _OF_OWN)
            groups.append(PageGroup(each.name, posed(each.T_world_carrier), colour, bodies, opacity))
    return tuple(groups)


def item_parts(scene: Scene) -> tuple[PageItem, ...]:
    """Convert the items of a scene.

    Args:
        scene: The scene.

    Returns:
        The items.
    """
    return tuple(
        PageItem(
            placed.id, placed.item.name.replace("_", " "), item_ink(placed.item),
            drawn_item(placed.item), posed(placed.T_world_item), _item_facts(placed),
        )
        for placed in scene.items
    )  # fmt: skip


def item_ink(item: Item) -> str:
    """Return the colour of an item.

    Args:
        item: The item.

    Returns:
        The colour as #rrggbb.
    """
    return _hex(item_colour(item))


def place_parts(scene: Scene) -> tuple[PagePlace, ...]:
    """Convert the places, with their mouths.

    Args:
        scene: The scene.

    Returns:
        The places.
    """
    return tuple(
        PagePlace(
            name,
            posed(scene.T_world_place(place) @ place.access.T_place_mouth),
            (place.access.width, place.access.height),
        )
        for name, place in scene.cell.places.items()
    )


def node_parts(cell: Cell) -> tuple[PageNode, ...]:
    """Convert the named configurations to points at their tips.

    Args:
        cell: The cell.

    Returns:
        The points.
    """
    arm = Arm(cell.robot)
    return tuple(
        PageNode(
            each.name,
            rounded(arm.tip(each.q, each.tool_state)[:3, 3]),
            _NODE_COLOURS.get(each.kind, _OTHER),
            each.kind in _MAIN,
        )
        for each in cell.configurations.values()
    )


def _item_facts(placed: PlacedItem) -> tuple[Fact, ...]:
    item = placed.item
    size = " x ".join(f"{1e3 * side:.0f}" for side in item.shape.extents)
    seals = ", ".join(f"{face} {share:.0%}" for face, share in item.seals.items() if share > 0.0)
    return (
        Fact("in", placed.location),
        Fact("size", f"{size} mm, {item.shape.kind}"),
        Fact("mass", f"{1e3 * item.mass:.0f} g"),
        Fact("seals", seals or f"none: {item.why_not}"),
    )


def _hex(colour: tuple[float, float, float, float]) -> str:
    return "#" + "".join(f"{round(255 * part):02x}" for part in colour[:3])


def _is_floor(body: Body) -> bool:
    return bool(np.sort(body.shape.extents)[1] > _FLOOR)
