"""Scenery: the cell as boxes, the arm as a skeleton, and paths of the tip of the cup."""

from __future__ import annotations

import numpy as np

from pickcli.cell.cell import Cell, NamedConfiguration
from pickcli.cell.shapes import Body
from pickcli.drawing.picture import Colour, DrawnBox, DrawnLine, DrawnNode
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm

STEP = 0.04  # rad or m of a joint between two points of a drawn path

_INKS = {
    "home": Colour.HOME,
    "bin": Colour.BIN,
    "camera": Colour.CAMERA,
    "tote": Colour.DELIVERY,
    "drop": Colour.DELIVERY,
}

_MAIN = ("home", "bin", "tote")

# Corners by the bits of their number: x, then y, then z.
_CORNERS = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)]) - 0.5


def solids(cell: Cell) -> tuple[DrawnBox, ...]:
    """Boxes of pod, tote and obstacles, without what is larger than the robot's surroundings (the floor).

    Args:
        cell: The cell.

    Returns:
        The boxes.
    """
    parts = [(body, cell.T_world_pod, Colour.POD) for body in cell.pod.bodies]
    parts += [(body, np.eye(4), Colour.TOTE) for body in cell.tote.bodies]
    parts += [(body, np.eye(4), Colour.OBSTACLE) for body in cell.obstacles.bodies]
    return tuple(
        DrawnBox(_corners(T @ body.T_parent_shape, body), ink)
        for body, T, ink in parts
        if not _is_floor(body)
    )


def skeleton(cell: Cell, arm: Arm) -> DrawnLine:
    """The arm at home, or at its first configuration: the origins of its frames, joined.

    Args:
        cell: The cell.
        arm: The arm.

    Returns:
        The line.
    """
    named = list(cell.configurations.values())
    q = next((each.q for each in named if each.kind == "home"), named[0].q)
    frames = np.asarray(arm.chain(cell.robot.tool.default_state).fk(q))[:, :3, 3]
    tip = arm.tip(q, cell.robot.tool.default_state)[:3, 3]
    return DrawnLine(np.vstack([cell.robot.T_world_base[:3, 3], frames, tip]), Colour.ARM, "the arm at home")


def node(named: NamedConfiguration, arm: Arm) -> DrawnNode:
    """Where the tip of the cup is in a named configuration.

    Args:
        named: The configuration.
        arm: The arm.

    Returns:
        The node.
    """
    ink = _INKS.get(named.kind, Colour.OTHER)
    return DrawnNode(arm.tip(named.q, named.tool_state)[:3, 3], ink, named.name, named.kind in _MAIN)


def tool_path(waypoints: Array, arm: Arm) -> Array:
    """The path of the tip along a polyline in joint space, the tool in its default state.

    Args:
        waypoints: (N, n) configurations.
        arm: The arm.

    Returns:
        (K, 3) m in the world.
    """
    counts = np.maximum(np.ceil(np.abs(np.diff(waypoints, axis=0)).max(axis=1) / STEP).astype(int), 1)
    pieces = [
        a + (b - a) * (np.arange(n) / n)[:, None]
        for a, b, n in zip(waypoints[:-1], waypoints[1:], counts, strict=True)
    ]
    return np.asarray(arm.tips(np.vstack([*pieces, waypoints[-1:]]), arm.robot.tool.default_state)[:, :3, 3])


def _corners(T: Array, body: Body) -> Array:
    """(8, 3) of the box around a shape."""
    return np.asarray(_CORNERS * body.shape.extents @ T[:3, :3].T + T[:3, 3])


def _is_floor(body: Body) -> bool:
    return bool(np.sort(body.shape.extents)[1] > 3.0)
