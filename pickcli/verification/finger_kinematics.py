"""Where the joints of fingers stand, by the verifier's own reckoning."""

from __future__ import annotations

from pickcli.cell.tool import Tool


def finger_position(tool: Tool, joint: str, width: float) -> float:
    """Position of a joint of a gripper at a width.

    The pads stand ``gap`` apart where the joints of the fingers stand at 0, and each finger goes half of the
    way.

    Args:
        tool: A tool with fingers.
        joint: Name of the joint.
        width: m between the pads.

    Returns:
        m; 0 for a joint of the tool that moves no finger.
    """
    assert tool.gripper is not None
    way = 0.5 * (width - tool.gripper.gap)
    return next((way * finger.opening for finger in tool.gripper.fingers if finger.joint == joint), 0.0)
