"""A parallel gripper in the world: a drive that closes it, fingers that mirror each other, pads that hold."""

from __future__ import annotations

from pickcli.cell.cell import Cell
from pickcli.cell.item import Item
from pickcli.cell.tool import MOVING, ToolState
from pickcli.cell.tools.gripper import ParallelGripper
from pickcli.geometry import Array
from pickcli.simulation.engine import Engine
from pickcli.simulation.engine_bodies import ITEM_FRICTION
from pickcli.simulation.fingers import Fingers
from pickcli.simulation.grip import Grip
from pickcli.simulation.hold_watch import GraspWatch, HoldWatch
from pickcli.simulation.servo import FingerDrive
from pickcli.simulation.simulated_tool import SimulatedTool, device_for
from pickcli.simulation.start_check import WIDTH_TOLERANCE
from pickcli.simulation.thresholds import Thresholds

PRESS_PEAK = 2.0  # of the force of fingers: with which they press for a moment as they meet an item
MIRROR_FORCE = 1e3  # N that the gear bears which lets fingers mirror each other


class SimulatedGripper(SimulatedTool):
    """The gripper of one robot.

    Args:
        cell: The cell as the robot's arm sees it.
        gripper: Its fingers.
        lag: s by which they follow.
        state: State of the tool at the start.
    """

    def __init__(self, cell: Cell, gripper: ParallelGripper, lag: float, state: ToolState) -> None:
        self.tool, self._gripper = cell.robot.tool, gripper
        (least, most), lead = self.tool.range, device_for(cell, self.tool.mover).lead
        delay = max(0.0, lead - (most - least) / gripper.closing_speed)
        self.drive: FingerDrive = FingerDrive(gripper, self.tool.position(state), delay, lag)

    def mount(self, engine: Engine, robot: str, items: dict[str, Item]) -> None:
        """Let the fingers mirror each other, their pads as rough as the cell says.

        Args:
            engine: Where the robot and the items are.
            robot: Name of the robot's body.
            items: What can be held, by the name of its body.
        """
        one, other = self._gripper.fingers
        engine.gear(robot, (one.link, other.link), one.opening * other.opening, MIRROR_FORCE)
        for finger in self._gripper.fingers:
            engine.roughen(robot, finger.link, self._gripper.limits.friction / ITEM_FRICTION)
        self._fingers = Fingers(engine, robot, self.tool, self._gripper, self.drive, items)

    @property
    def grip(self) -> Grip:
        """What holds items: the fingers."""
        return self._fingers

    @property
    def fingers(self) -> Fingers:
        """What the fingers do."""
        return self._fingers

    @property
    def max_press(self) -> float:
        """N with which a finger presses at its peak."""
        return PRESS_PEAK * self._gripper.limits.force

    def state(self, measured: Array) -> ToolState:
        """The state that the cell names; where the fingers stand on something, their width.

        Args:
            measured: (2,) where the fingers are.

        Returns:
            The state, or MOVING.
        """
        tool, width = self.tool, self._fingers.width
        arrived = (s for s in tool.states if abs(tool.position(s) - width) < WIDTH_TOLERANCE)
        return next(arrived, ToolState.of_width(width) if self._fingers.is_holding else MOVING)

    def has_hold(self, seal: float) -> bool:
        """Whether the fingers stand.

        Args:
            seal: Of no account.

        Returns:
            True if they do.
        """
        return self._fingers.are_standing

    def watch(self, thresholds: Thresholds) -> HoldWatch:
        """What judges the width at which the fingers stand.

        Args:
            thresholds: Beyond which it stops.

        Returns:
            A watch over the encoder.
        """
        return GraspWatch(self._fingers, thresholds)
