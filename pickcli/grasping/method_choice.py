"""Which method of grasping a tool has: the one place where picks are told from another by their tool."""

from __future__ import annotations

from collections.abc import Iterable

from pickcli.cell.item import Item
from pickcli.cell.tool import Tool
from pickcli.cell.tools.gripper import ParallelGripper
from pickcli.grasping.grasp_method import GraspMethod
from pickcli.grasping.pinch_grasping import PinchGrasping
from pickcli.grasping.suction_grasping import SuctionGrasping


def grasp_method(tool: Tool) -> GraspMethod:
    """The method of a tool.

    Args:
        tool: What is mounted; a bare flange counts as a tool whose cup is missing, which the first question
            about it tells.

    Returns:
        The method.
    """
    if isinstance(tool.grip, ParallelGripper):
        return PinchGrasping(tool, tool.grip)
    return SuctionGrasping(tool)


def may_hold(tools: Iterable[Tool], item: Item) -> bool:
    """Whether there is a way, known or not, in which one of several tools holds an item.

    Args:
        tools: The tools, of an arm each.
        item: The item.

    Returns:
        True if there may be one; asked before anything is known of where the item lies.
    """
    return any(grasp_method(tool).may_hold(item) for tool in tools)
