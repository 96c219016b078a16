"""What carries out a plan: the simulated world, or a robot of the user's own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from pickcli.cell.cell import Cell
from pickcli.cell.device import Device
from pickcli.cell.tool import ToolState
from pickcli.errors import UnknownNameError
from pickcli.geometry import Array
from pickcli.scene.scene import Scene
from pickcli.simulation.reality import DEFAULT, Reality


class Driver(Protocol):
    """A robot that takes set points one period apart, is measured, and whose devices are switched.

    The simulated ``World`` is one. ``check_driver`` tells whether another one keeps to what is said here.
    """

    @property
    def cell(self) -> Cell:
        """The cell, as the arm that moves sees it."""

    @property
    def time_step(self) -> float:
        """Period of the set points, s."""

    @property
    def t(self) -> float:
        """Time that has passed since any moment before the first step, s; every step takes about a period."""

    @property
    def q(self) -> Array:
        """Measured configuration (n,), in the order of the cell's joints. It is not changed afterwards."""

    @property
    def tool_state(self) -> ToolState:
        """State of the tool as it stands, MOVING on the way; as it was told, where that is not measured."""

    def command(self, q: Array) -> None:
        """Set where the robot is to be at the end of the next step, and until there is another set point.

        Args:
            q: (n,) configuration. It is not kept: the caller may change it afterwards.
        """

    def act(self, device: str, action: str) -> bool | None:
        """Switch a device at once, or read a sensor.

        Args:
            device: Name of a device of the cell.
            action: One of its actions.

        Returns:
            A sensor's answer, whether something is held; None for other devices.

        Raises:
            UnknownNameError: If there is no such device or action.
        """

    def step(self) -> None:
        """Let one period pass. A real robot waits until the next set point is due."""

    def close(self) -> None:
        """Let go of everything: connections, memory. The robot stands."""


@dataclass(frozen=True, eq=False)
class DriverRequest:
    """What a driver is made for.

    Attributes:
        scene: How things truly stand, as far as the user says; its cell is as the arm that moves sees it.
        q: (n,) where the user says that the robot stands: simulated ones begin there, real ones measure.
        tool_state: State of the tool there.
        reality: How a simulated world differs from its model.
        seed: Seed of all that is random about it.
    """

    scene: Scene
    q: Array
    tool_state: ToolState
    reality: Reality = field(default=DEFAULT)
    seed: int = 0


DriverFactory = Callable[[DriverRequest], Driver]


def device_for(cell: Cell, device: str, action: str) -> Device:
    """Find a device that has an action.

    Args:
        cell: The cell.
        device: Name of the device.
        action: One of its actions.

    Returns:
        The device.

    Raises:
        UnknownNameError: If there is no such device or action.
    """
    if device not in cell.devices:
        raise UnknownNameError("device", device, sorted(cell.devices))
    if action not in cell.devices[device].actions:
        raise UnknownNameError("action", action, cell.devices[device].actions, device)
    return cell.devices[device]
