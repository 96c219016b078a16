"""Selects the simulated tool of a cell; no other module of this package depends on the kind of the tool."""

from __future__ import annotations

from pickcli.cell.cell import Cell
from pickcli.cell.tool import ToolState
from pickcli.cell.tools.gripper import ParallelGripper
from pickcli.cell.tools.suction_cup import SuctionCup
from pickcli.simulation.reality import Reality
from pickcli.simulation.simulated_cup import SimulatedCup
from pickcli.simulation.simulated_gripper import SimulatedGripper
from pickcli.simulation.simulated_tool import BareTool, SimulatedTool


def simulated_tool(cell: Cell, reality: Reality, lag: float, state: ToolState) -> SimulatedTool:
    """Create the tool of an arm for a world.

    Args:
        cell: The cell as seen by the arm.
        reality: Deviations of the world from the planner's model.
        lag: s, lag of the joints.
        state: State of the tool at the start.

    Returns:
        The tool, not yet mounted.

    Raises:
        InputError: No device of the cell moves the tool's joints.
    """
    grip = cell.robot.tool.grip
    if isinstance(grip, ParallelGripper):
        return SimulatedGripper(cell, grip, lag, state)
    if isinstance(grip, SuctionCup):
        return SimulatedCup(cell, grip, reality, lag, state)
    return BareTool(cell.robot.tool)
