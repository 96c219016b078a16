"""The states that the default cell names."""

from pickcli.cell.tool import MOVING, ToolState

STRAIGHT = ToolState("straight")  # the cup along the lance
DOWN = ToolState("down")  # the cup at a right angle to it
ALL_STATES = (STRAIGHT, DOWN, MOVING)
