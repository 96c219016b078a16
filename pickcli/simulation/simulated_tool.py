"""Base class of simulated tools: drive, grip and state.

Each kind of tool has a subclass; `tool_choice` selects it by the cell's tool.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

from pickcli.cell.cell import Cell
from pickcli.cell.device import Device, DeviceKind
from pickcli.cell.item import Item
from pickcli.cell.tool import Tool, ToolState
from pickcli.errors import InputError
from pickcli.geometry import Array
from pickcli.motion.plan import Grasp
from pickcli.scene.scene import PlacedItem, PoseNoise
from pickcli.simulation.engine import Engine
from pickcli.simulation.fingers import Fingers
from pickcli.simulation.grip import Grip, NoGrip
from pickcli.simulation.hold_watch import HoldWatch, NoWatch
from pickcli.simulation.servo import ToolDrive
from pickcli.simulation.suction import Suction
from pickcli.simulation.thresholds import Thresholds


class SimulatedTool(ABC):
    """The tool of one robot in a world.

    Attributes:
        tool: The tool of the cell.
        drive: Drive of its joints; None if its state moves no joint.
    """

    tool: Tool
    drive: ToolDrive | None

    @property
    @abstractmethod
    def grip(self) -> Grip:
        """The grip that holds items; available once the tool is mounted."""

    @property
    @abstractmethod
    def max_press(self) -> float:
        """Largest force in N at one point with which the contact links may press on planned contacts."""

    @abstractmethod
    def mount(self, engine: Engine, robot: str, items: dict[str, Item]) -> None:
        """Add the tool to the physics.

        Args:
            engine: The engine with the robot and the items.
            robot: Name of the robot's body.
            items: Items that can be held, by body name.
        """

    @abstractmethod
    def state(self, measured: Array) -> ToolState:
        """Return the present state of the tool.

        Args:
            measured: (k,) joint positions.

        Returns:
            A state that it can rest in, or MOVING.
        """

    @abstractmethod
    def has_hold(self, grasp: Grasp, placed: PlacedItem, noise: PoseNoise) -> bool:
        """Whether the tool has taken hold well enough for the lift of a plan.

        Args:
            grasp: Grasp of the item.
            placed: The item where the robot believes it to be.
            noise: Bounds of the error of that pose.

        Returns:
            True if it has.
        """

    @abstractmethod
    def watch(self, thresholds: Thresholds) -> HoldWatch:
        """Create the supervision of the hold for one execution.

        Args:
            thresholds: Thresholds of a stop.

        Returns:
            A new watch, independent of earlier motions.
        """

    @property
    def pressure(self) -> float:
        """Pressure (Pa) below ambient in the cup; 0 without a cup."""
        return 0.0

    @property
    def suction(self) -> Suction:
        """The suction of the cup. Raises InputError without a cup."""
        raise InputError(f"no suction cup is mounted on {self.tool.flange_link}")

    @property
    def fingers(self) -> Fingers | None:
        """The simulated fingers; None without fingers."""
        return None


class BareTool(SimulatedTool):
    """A flange on which nothing is mounted.

    Args:
        tool: The bare tool.
    """

    def __init__(self, tool: Tool) -> None:
        self.tool, self.drive = tool, None
        self._grip = NoGrip()

    @property
    def grip(self) -> Grip:
        """The grip of a flange, which holds nothing."""
        return self._grip

    @property
    def max_press(self) -> float:
        """Largest pressing force in N: 0."""
        return 0.0

    def mount(self, engine: Engine, robot: str, items: dict[str, Item]) -> None:
        """Do nothing, as there is no tool.

        Args:
            engine: Ignored.
            robot: Ignored.
            items: Ignored.
        """

    def state(self, measured: Array) -> ToolState:
        """Return the only state of a flange.

        Args:
            measured: (0,).

        Returns:
            The state.
        """
        return self.tool.default_state

    def has_hold(self, grasp: Grasp, placed: PlacedItem, noise: PoseNoise) -> bool:
        """Whether an item is held: never.

        Args:
            grasp: Not used.
            placed: Not used.
            noise: Not used.

        Returns:
            False.
        """
        return False

    def watch(self, thresholds: Thresholds) -> HoldWatch:
        """Create a watch that never requests a stop.

        Args:
            thresholds: Not used.

        Returns:
            The watch.
        """
        return NoWatch()


def first_device_of(cell: Cell, kind: DeviceKind) -> Device:
    """Return the device for the simulation of a tool.

    Args:
        cell: The cell.
        kind: Kind of the device.

    Returns:
        The first device of that kind.

    Raises:
        InputError: The cell has none.
    """
    device = next((d for d in cell.devices.values() if d.kind is kind), None)
    if device is None:
        raise InputError(
            f"cell {cell.name}: has no device of kind {kind}, which its tool is simulated "
            "with; add one under `devices` in its cell.yaml"
        )
    return device
