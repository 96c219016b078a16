"""Positions of finger joints, computed independently of the planner."""

from __future__ import annotations

from pickcli.cell.tool import Tool


def finger_position(tool: Tool, joint: str, width: float) -> float:
    """Return the position of a gripper joint at a width.

    The pads are ``gap`` apart when the finger joints are at 0, and each finger moves half of the difference.

    Args:
        tool: A tool with fingers.
        joint: Name of the joint.
        width: m between the pads.

    Returns:
        m; 0 for a joint of the tool that moves no finger.
    """
    assert tool.gripper is not None
    way = 0.5 * (width - tool.gripper.gap)
    return next((way * finger.opening_sign for finger in tool.gripper.fingers if finger.joint == joint), 0.0)
