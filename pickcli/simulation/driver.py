"""Protocol of drivers, which carry out plans: the simulated world, or a real robot."""

from __future__ import annotations

from collections.abc import Callable, Mapping
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
    """A robot that takes periodic set points, is measured, and whose devices can be switched.

    The simulated ``World`` is a driver. ``check_driver`` tests others against this protocol.
    """

    @property
    def cell(self) -> Cell:
        """The cell as seen by the moving arm."""

    @property
    def time_step(self) -> float:
        """Period of the set points, s."""

    @property
    def t(self) -> float:
        """Time since an arbitrary moment before the first step, s; every step takes about a period."""

    @property
    def q(self) -> Array:
        """Measured configuration (n,), in the order of the cell's joints. The array is not modified later."""

    @property
    def tool_state(self) -> ToolState:
        """Current state of the tool, MOVING in between; the commanded state if it is not measured."""

    def command(self, q: Array) -> None:
        """Set the target configuration at the end of the next step, valid until the next set point.

        Args:
            q: (n,) configuration. The driver must copy it: the caller may modify it later.
        """

    def act(self, device: str, action: str) -> bool | None:
        """Switch a device immediately, or read a sensor.

        Args:
            device: Name of a device of the cell.
            action: One of its actions.

        Returns:
            A sensor's reading, whether an item is held; None for other devices.

        Raises:
            UnknownNameError: There is no such device or action.
        """

    def step(self) -> None:
        """Wait for one period. A real robot's driver returns when the next set point is due."""

    def close(self) -> None:
        """Release connections and memory. The robot stops."""


@dataclass(frozen=True, eq=False)
class DriverRequest:
    """Parameters for creating a driver.

    Attributes:
        scene: The actual scene as far as the user knows it; its cell is as seen by the moving arm.
        q: (n,) configuration stated by the user: simulations start there, real robots measure.
        tool_state: State of the tool at the start.
        reality: Deviations of a simulated world from its model.
        seed: Seed of all random deviations.
        belt_speeds: m/s of the conveyors that run, by name.
    """

    scene: Scene
    q: Array
    tool_state: ToolState
    reality: Reality = field(default=DEFAULT)
    seed: int = 0
    belt_speeds: Mapping[str, float] = field(default_factory=dict)


DriverFactory = Callable[[DriverRequest], Driver]


def device_for(cell: Cell, device: str, action: str) -> Device:
    """Find a device by name and check that it has an action.

    Args:
        cell: The cell.
        device: Name of the device.
        action: One of its actions.

    Returns:
        The device.

    Raises:
        UnknownNameError: There is no such device or action.
    """
    if device not in cell.devices:
        raise UnknownNameError("device", device, sorted(cell.devices))
    if action not in cell.devices[device].actions:
        raise UnknownNameError("action", action, cell.devices[device].actions, device)
    return cell.devices[device]
