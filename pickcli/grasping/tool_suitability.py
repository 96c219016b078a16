"""Whether any of several tools may hold an item, asked before anything is known of where it lies."""

from __future__ import annotations

from collections.abc import Iterable

from pickcli.cell.item import Item
from pickcli.cell.tool import Tool


def may_hold(tools: Iterable[Tool], item: Item) -> bool:
    """Whether there is a way, known or not, in which one of the tools holds an item.

    Args:
        tools: The tools, of an arm each.
        item: The item.

    Returns:
        True if it is one for suction and there is a cup, or if fingers open wider than its least extent.
    """
    return any(_may_hold(tool, item) for tool in tools)


def _may_hold(tool: Tool, item: Item) -> bool:
    if tool.gripper is None:
        return item.suction
    return float(min(item.shape.extents)) < max(tool.positions.values())
