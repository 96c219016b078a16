"""How far a cup is pressed on an item so that its whole rim meets the face despite pose errors."""

from __future__ import annotations

import numpy as np

from pickcli.cell.tool import Tool
from pickcli.collision.stage_contacts import CupPress, Outward
from pickcli.geometry import Array
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
    return float(overtravels(grasp.face, grasp.T_item_tip[None], tool, noise)[0])


def overtravels(face: str, T_item_tip: Array, tool: Tool, noise: PoseNoise) -> Array:
    """Return how far the cup is pressed beyond the surface for many grasps on one face (see ``overtravel``).

    Args:
        face: Face under the cup.
        T_item_tip: (N, 4, 4) poses of the tool at the grasps.
        tool: The tool with the cup.
        noise: Bounds of the item's pose error.

    Returns:
        (N,) m along the cup's axis.
    """
    return _overtravels(*_error_and_lag(face, T_item_tip, tool, noise), tool)


def _overtravels(error: Array, lag: Array, tool: Tool) -> Array:
    # The far side of a tilted cup must meet the surface as well.
    off = error + lag
    # With the opposite pose error the bellows must not be compressed beyond their stroke. The vacuum closes a
    # remaining gap.
    most = np.maximum(tool.cup.stroke - off, LEAST_OF_STROKE * tool.cup.stroke)
    return np.minimum(np.minimum(off + PRESS, MOST_OF_STROKE * tool.cup.stroke), most)


def max_press_depth(grasp: Grasp, tool: Tool, noise: PoseNoise) -> float:
    """Return how far the cup goes beyond the surface if the item is as near as its pose error allows.

    Args:
        grasp: Grasp of the item.
        tool: The tool with the cup.
        noise: Bounds of the item's pose error.

    Returns:
        m along the cup's axis.
    """
    error, lag = _error_and_lag(grasp.face, grasp.T_item_tip[None], tool, noise)
    return float((_overtravels(error, lag, tool) + error)[0])


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
    error, lag = _error_and_lag(grasp.face, grasp.T_item_tip[None], tool, noise)
    beyond = float(_overtravels(error, lag, tool)[0])
    depth = beyond + float(lag[0]) + cup_excess
    return CupPress(outward_of(grasp.face, R_world_item), (x, y, z), depth, beyond, grasp.face)


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


def _error_and_lag(face: str, T_item_tip: Array, tool: Tool, noise: PoseNoise) -> tuple[Array, Array]:
    """Bound two errors of the surface under the cup at poses (N, 4, 4), in m along the cup's axis.

    Returns:
        (N,) the error due to the item's pose, and (N,) how much later the far side of a tilted cup meets the
        face than its middle.
    """
    point, axis = T_item_tip[:, :3, 3], T_item_tip[:, :3, 2]
    along = np.einsum("ni,ni->n", point, axis)
    off_axis = point - along[:, None] * axis
    aside = np.sqrt(np.einsum("ni,ni->n", off_axis, off_axis))
    lag = tool.cup.radius * np.sin(tilt_on(face, T_item_tip))
    return noise.at(aside), lag
