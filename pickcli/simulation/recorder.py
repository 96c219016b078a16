"""A driver without a robot, which follows exactly and records its commands."""

from __future__ import annotations

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.device import DeviceKind
from pickcli.cell.tool import MOVING, ToolState
from pickcli.geometry import Array
from pickcli.simulation.driver import DriverRequest, device_for

TIME_STEP = 1e-3  # s


class Recorder:
    """Driver that is at every set point at the end of its step. Its sensors always read that an item is held.

    Args:
        cell: The cell as seen by the moving arm.
        q: (n,) initial configuration.
        tool_state: Initial state of the tool; the default state if None.
        time_step: s between set points.

    Attributes:
        set_points: (t, q) after every step.
        actions: (t, device, action) of every switched or read device.
    """

    def __init__(
        self, cell: Cell, q: Array, tool_state: ToolState | None = None, time_step: float = TIME_STEP
    ) -> None:
        self._cell, self._time_step, self._n_steps = cell, time_step, 0
        self._q = self._command = np.array(q, dtype=float)
        self._state, self._t_arrived = tool_state or cell.robot.tool.default_state, 0.0
        self.set_points: list[tuple[float, Array]] = []
        self.actions: list[tuple[float, str, str]] = []

    @classmethod
    def connect(cls, request: DriverRequest) -> Recorder:
        """Create a recorder from a request.

        Args:
            request: Parameters for creating it.

        Returns:
            The recorder.
        """
        return cls(request.scene.cell, request.q, request.tool_state)

    @property
    def cell(self) -> Cell:
        """The cell as seen by the moving arm."""
        return self._cell

    @property
    def time_step(self) -> float:
        """Period of the set points, s."""
        return self._time_step

    @property
    def t(self) -> float:
        """Sum of all steps, s."""
        return self._n_steps * self._time_step

    @property
    def q(self) -> Array:
        """The set point of the last step (n,)."""
        return self._q

    @property
    def tool_state(self) -> ToolState:
        """State of the tool: the commanded one, once the lead of its device has passed."""
        return self._state if self.t >= self._t_arrived else MOVING

    def command(self, q: Array) -> None:
        """Set the configuration at the end of the next step.

        Args:
            q: (n,) configuration.
        """
        self._command = np.array(q, dtype=float)

    def act(self, device: str, action: str) -> bool | None:
        """Record a switched or read device.

        Args:
            device: Name of a device of the cell.
            action: One of its actions.

        Returns:
            True for a sensor, None for other devices.

        Raises:
            UnknownNameError: There is no such device or action.
        """
        found = device_for(self._cell, device, action)
        self.actions.append((self.t, device, action))
        if found.kind is self._cell.robot.tool.mover:
            self._state, self._t_arrived = ToolState(action), self.t + found.lead
        return True if found.kind is DeviceKind.SENSOR else None

    def step(self) -> None:
        """Move to the set point."""
        self._n_steps += 1
        self._q = self._command
        self.set_points.append((self.t, self._q))

    def close(self) -> None:
        """Do nothing, as nothing is connected."""
