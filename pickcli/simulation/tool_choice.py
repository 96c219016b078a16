"""Which simulated tool a cell has: the one place of the simulation that asks for the kind of a tool."""

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
    """Make the tool of an arm for a world.

    Args:
        cell: The cell as the arm sees it.
        reality: How the world differs from what the planner believes.
        lag: s by which joints follow.
        state: State of the tool at the start.

    Returns:
        The tool, not yet mounted.

    Raises:
        InputError: If no device of the cell moves its joints.
    """
    grip = cell.robot.tool.grip
    if isinstance(grip, ParallelGripper):
        return SimulatedGripper(cell, grip, lag, state)
    if isinstance(grip, SuctionCup):
        return SimulatedCup(cell, grip, reality, lag, state)
    return BareTool(cell.robot.tool)
