"""What the simulated world has of a tool: what moves it, what it holds items by, in which state it stands.

There is one class for each kind of tool; `tool_choice` chooses by what a cell has mounted.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

from pickcli.cell.cell import Cell
from pickcli.cell.device import Device, DeviceKind
from pickcli.cell.item import Item
from pickcli.cell.tool import Tool, ToolState
from pickcli.errors import InputError
from pickcli.geometry import Array
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
        tool: What the cell says of it.
        drive: What moves its joints; None where its state moves none.
    """

    tool: Tool
    drive: ToolDrive | None

    @property
    @abstractmethod
    def grip(self) -> Grip:
        """What holds items, once the tool is mounted."""

    @property
    @abstractmethod
    def max_press(self) -> float:
        """N with which what holds may press on what it is planned to touch, at one point."""

    @abstractmethod
    def mount(self, engine: Engine, robot: str, items: dict[str, Item]) -> None:
        """Take part in the physics.

        Args:
            engine: Where the robot and the items are.
            robot: Name of the robot's body.
            items: What can be held, by the name of its body.
        """

    @abstractmethod
    def state(self, measured: Array) -> ToolState:
        """The state in which the tool stands.

        Args:
            measured: (k,) where its joints are.

        Returns:
            One that it can rest in, or MOVING.
        """

    @abstractmethod
    def has_hold(self, seal: float) -> bool:
        """Whether the tool has taken hold as far as a plan counts on it when it lifts.

        Args:
            seal: Share of full vacuum that the item's face is to keep, of no account without a cup.

        Returns:
            True if it has.
        """

    @abstractmethod
    def watch(self, thresholds: Thresholds) -> HoldWatch:
        """What judges the hold while a plan is carried out.

        Args:
            thresholds: Beyond which it stops.

        Returns:
            What judges, which knows nothing of earlier motions.
        """

    @property
    def pressure(self) -> float:
        """Pa below ambient in the cup; 0 where there is none."""
        return 0.0

    @property
    def suction(self) -> Suction:
        """What the cup does. Raises InputError where none is mounted."""
        raise InputError(f"no suction cup is mounted on {self.tool.flange_link}")

    @property
    def fingers(self) -> Fingers | None:
        """What the fingers do; None where there are none."""
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
        """What holds items: a flange, which holds none."""
        return self._grip

    @property
    def max_press(self) -> float:
        """The force in N that the tool presses with at most: 0."""
        return 0.0

    def mount(self, engine: Engine, robot: str, items: dict[str, Item]) -> None:
        """Do nothing, for there is nothing to mount.

        Args:
            engine: Where the robot is.
            robot: Name of the robot's body.
            items: Items by name, none of which it holds.
        """

    def state(self, measured: Array) -> ToolState:
        """The state that the tool is in: a flange has one only.

        Args:
            measured: (0,).

        Returns:
            The state.
        """
        return self.tool.default_state

    def has_hold(self, seal: float) -> bool:
        """Whether the tool has taken hold of an item: never.

        Args:
            seal: Not used.

        Returns:
            False.
        """
        return False

    def watch(self, thresholds: Thresholds) -> HoldWatch:
        """A watch on the hold that never stops a motion, for nothing is held.

        Args:
            thresholds: Not used.

        Returns:
            The watch.
        """
        return NoWatch()


def device_for(cell: Cell, kind: DeviceKind) -> Device:
    """The device that a tool is simulated with.

    Args:
        cell: The cell.
        kind: What the device does.

    Returns:
        The first device of that kind.

    Raises:
        InputError: If the cell has none.
    """
    device = next((d for d in cell.devices.values() if d.kind is kind), None)
    if device is None:
        raise InputError(
            f"cell {cell.name}: has no device of kind {kind}, which its tool is simulated "
            "with; add one under `devices` in its cell.yaml"
        )
    return device
