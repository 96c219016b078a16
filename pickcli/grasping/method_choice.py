"""Choice of the grasp method by the kind of the tool; no other module of planning distinguishes them."""

from __future__ import annotations

from collections.abc import Iterable

from pickcli.cell.item import Item
from pickcli.cell.tool import Tool
from pickcli.cell.tools.gripper import ParallelGripper
from pickcli.grasping.grasp_method import GraspMethod
from pickcli.grasping.pinch_grasping import PinchGrasping
from pickcli.grasping.suction_grasping import SuctionGrasping


def grasp_method(tool: Tool) -> GraspMethod:
    """Return the method of a tool.

    Args:
        tool: The mounted tool. A bare flange is treated as a tool without its cup, so the first access to the
            cup raises an error.

    Returns:
        The method.
    """
    if isinstance(tool.grip, ParallelGripper):
        return PinchGrasping(tool, tool.grip)
    return SuctionGrasping(tool)


def may_hold(tools: Iterable[Tool], item: Item) -> bool:
    """Whether one of several tools may be able to hold an item in some way.

    Args:
        tools: The tools, of an arm each.
        item: The item.

    Returns:
        True if one may, regardless of the item's pose.
    """
    return any(grasp_method(tool).may_hold(item) for tool in tools)
