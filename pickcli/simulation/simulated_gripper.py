"""Simulated parallel gripper: a drive, fingers that mirror each other, and pads that hold items."""

from __future__ import annotations

from pickcli.cell.cell import Cell
from pickcli.cell.item import Item
from pickcli.cell.tool import MOVING, ToolState
from pickcli.cell.tools.gripper import ParallelGripper
from pickcli.geometry import Array
from pickcli.motion.plan import Grasp
from pickcli.scene.scene import PlacedItem, PoseNoise
from pickcli.simulation.engine import Engine
from pickcli.simulation.engine_bodies import ITEM_FRICTION
from pickcli.simulation.fingers import Fingers
from pickcli.simulation.grip import Grip
from pickcli.simulation.hold_watch import GraspWatch, HoldWatch
from pickcli.simulation.servo import FingerDrive
from pickcli.simulation.simulated_tool import SimulatedTool, first_device_of
from pickcli.simulation.start_check import WIDTH_TOLERANCE
from pickcli.simulation.thresholds import Thresholds

PRESS_PEAK = 2.0  # largest force of a finger on first contact, over its steady force
MIRROR_FORCE = 1e3  # N, largest force of the gear that couples the fingers


class SimulatedGripper(SimulatedTool):
    """The gripper of one robot.

    Args:
        cell: The cell as seen by the robot's arm.
        gripper: Its gripper.
        lag: s, lag of the fingers.
        state: State of the tool at the start.
    """

    def __init__(self, cell: Cell, gripper: ParallelGripper, lag: float, state: ToolState) -> None:
        self.tool, self._gripper = cell.robot.tool, gripper
        (least, most), lead = self.tool.range, first_device_of(cell, self.tool.mover).lead
        delay = max(0.0, lead - (most - least) / gripper.closing_speed)
        self.drive: FingerDrive = FingerDrive(gripper, self.tool.position(state), delay, lag)

    def mount(self, engine: Engine, robot: str, items: dict[str, Item]) -> None:
        """Couple the fingers, and set the friction of the pads.

        Args:
            engine: The engine with the robot and the items.
            robot: Name of the robot's body.
            items: Items that can be held, by body name.
        """
        one, other = self._gripper.fingers
        engine.gear(robot, (one.link, other.link), one.opening_sign * other.opening_sign, MIRROR_FORCE)
        for finger in self._gripper.fingers:
            engine.roughen(robot, finger.link, self._gripper.limits.friction / ITEM_FRICTION)
        self._fingers = Fingers(engine, robot, self.tool, self._gripper, self.drive, items)

    @property
    def grip(self) -> Grip:
        """The grip of the fingers."""
        return self._fingers

    @property
    def fingers(self) -> Fingers:
        """The simulated fingers."""
        return self._fingers

    @property
    def max_press(self) -> float:
        """Peak force of a finger, N."""
        return PRESS_PEAK * self._gripper.limits.force

    def state(self, measured: Array) -> ToolState:
        """Return the state named by the cell; if the fingers stopped on an item, their width.

        Args:
            measured: (2,) positions of the fingers.

        Returns:
            The state, or MOVING.
        """
        tool, width = self.tool, self._fingers.width
        arrived = (s for s in tool.states if abs(tool.position(s) - width) < WIDTH_TOLERANCE)
        return next(arrived, ToolState.of_width(width) if self._fingers.is_holding else MOVING)

    def has_hold(self, grasp: Grasp, placed: PlacedItem, noise: PoseNoise) -> bool:
        """Whether the fingers have stopped.

        Args:
            grasp: Ignored.
            placed: Ignored.
            noise: Ignored.

        Returns:
            True if they do.
        """
        return self._fingers.are_standing

    def watch(self, thresholds: Thresholds) -> HoldWatch:
        """Create the supervision of the fingers' width.

        Args:
            thresholds: Thresholds of a stop.

        Returns:
            A watch of the encoder.
        """
        return GraspWatch(self._fingers, thresholds)
