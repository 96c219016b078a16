"""How far a cup is pressed on an item so that its whole rim meets the face despite pose errors."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from pickcli.cell.tool import Tool
from pickcli.collision.stage_contacts import CupPress, Outward
from pickcli.geometry import Array, cross
from pickcli.grasping.surfaces import flat_normal, tilt_on
from pickcli.motion.plan import Grasp
from pickcli.scene.scene import PoseNoise

PRESS = 0.001  # m that the bellows are compressed at least
MOST_OF_STROKE, LEAST_OF_STROKE = 0.75, 0.4  # share of the bellows' stroke that pressing uses


def overtravel(grasp: Grasp, tool: Tool, noise: PoseNoise) -> float:
    """Return how far the cup is pressed beyond the surface, so that its whole rim meets the item.

    Args:
        grasp: Grasp of the item.
        tool: The tool with the cup.
        noise: Bounds of the item's pose error.

    Returns:
        m along the cup's axis.
    """
    # The far side of a tilted cup must meet the surface as well.
    error, lag = _error_and_lag(grasp, tool, noise)
    off = error + lag
    # With the opposite pose error the bellows must not be compressed beyond their stroke. The vacuum closes a
    # remaining gap.
    most = max(tool.cup.stroke - off, LEAST_OF_STROKE * tool.cup.stroke)
    return min(off + PRESS, MOST_OF_STROKE * tool.cup.stroke, most)


def max_press_depth(grasp: Grasp, tool: Tool, noise: PoseNoise) -> float:
    """Return how far the cup goes beyond the surface if the item is as near as its pose error allows.

    Args:
        grasp: Grasp of the item.
        tool: The tool with the cup.
        noise: Bounds of the item's pose error.

    Returns:
        m along the cup's axis.
    """
    error, _ = _error_and_lag(grasp, tool, noise)
    return overtravel(grasp, tool, noise) + error


def cup_press(grasp: Grasp, tool: Tool, noise: PoseNoise, R_world_item: Array, cup_excess: float) -> CupPress:
    """Describe the press of the cup on the item, which determines the allowed contacts.

    Args:
        grasp: Grasp of the item.
        tool: The tool with the cup.
        noise: Bounds of the item's pose error.
        R_world_item: (3, 3) orientation of the item.
        cup_excess: m by which the model of the cup is larger than the cup.

    Returns:
        Face, direction, depth and overtravel, in the world.
    """
    x, y, z = (R_world_item @ grasp.T_item_tip[:3, 2]).tolist()
    beyond = overtravel(grasp, tool, noise)
    _, lag = _error_and_lag(grasp, tool, noise)
    depth = beyond + lag + cup_excess
    return CupPress(outward_of(grasp.face, R_world_item), (x, y, z), depth, beyond)


def outward_of(face: str, R_world_item: Array) -> Outward | None:
    """Return the normal of a face in the world.

    Args:
        face: Name of the face.
        R_world_item: (3, 3) orientation of the item.

    Returns:
        Unit vector that points out of the item; None for a curved face.
    """
    normal = flat_normal(face)
    if normal is None:
        return None
    x, y, z = (R_world_item @ normal).tolist()
    return x, y, z


def _error_and_lag(grasp: Grasp, tool: Tool, noise: PoseNoise) -> tuple[float, float]:
    """Bound two errors of the surface under the cup, in m along the cup's axis.

    Returns:
        The error due to the item's pose, and how much later the far side of a tilted cup meets the face than
        its middle.
    """
    return _of_press(grasp.face, grasp.T_item_tip[:3, 2:].tobytes(), tool, noise)


@lru_cache(
    maxsize=4096
)  # turns about the cup's axis have the same press, and each grasp needs it several times
def _of_press(face: str, axis_and_point: bytes, tool: Tool, noise: PoseNoise) -> tuple[float, float]:
    T_item_tip = np.eye(4)
    T_item_tip[:3, 2:] = np.frombuffer(axis_and_point).reshape(3, 2)
    aside = float(np.linalg.norm(cross(T_item_tip[:3, 3], T_item_tip[:3, 2])))
    lag = tool.cup.radius * float(np.sin(tilt_on(face, T_item_tip)))
    return noise.position + noise.angle * aside, lag
