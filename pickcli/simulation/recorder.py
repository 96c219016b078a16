"""A driver without a robot: it follows exactly, and records what it was told."""

from __future__ import annotations

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.device import DeviceKind
from pickcli.cell.tool import MOVING, ToolState
from pickcli.geometry import Array
from pickcli.simulation.driver import DriverRequest, device_for

TIME_STEP = 1e-3  # s


class Recorder:
    """Stands at every set point at the end of its step. Its sensors answer what the plan hopes for: held.

    Args:
        cell: The cell, as the arm that moves sees it.
        q: (n,) where it stands.
        tool_state: State of its tool; the default state if None.
        time_step: s between set points.

    Attributes:
        set_points: (t, q) after every step.
        actions: (t, device, action) of everything that was switched or read.
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
        """Make a recorder that begins where the request says.

        Args:
            request: What it is made for.

        Returns:
            The recorder.
        """
        return cls(request.scene.cell, request.q, request.tool_state)

    @property
    def cell(self) -> Cell:
        """The cell, as the arm that moves sees it."""
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
        """The last set point whose step has passed (n,)."""
        return self._q

    @property
    def tool_state(self) -> ToolState:
        """State of the tool: the commanded one, once the lead of its device has passed."""
        return self._state if self.t >= self._t_arrived else MOVING

    def command(self, q: Array) -> None:
        """Set where it stands at the end of the next step.

        Args:
            q: (n,) configuration.
        """
        self._command = np.array(q, dtype=float)

    def act(self, device: str, action: str) -> bool | None:
        """Record a switch, or a reading.

        Args:
            device: Name of a device of the cell.
            action: One of its actions.

        Returns:
            True for a sensor, None for other devices.

        Raises:
            UnknownNameError: If there is no such device or action.
        """
        found = device_for(self._cell, device, action)
        self.actions.append((self.t, device, action))
        if found.kind is self._cell.robot.tool.mover:
            self._state, self._t_arrived = ToolState(action), self.t + found.lead
        return True if found.kind is DeviceKind.SENSOR else None

    def step(self) -> None:
        """Stand at the set point."""
        self._n_steps += 1
        self._q = self._command
        self.set_points.append((self.t, self._q))

    def close(self) -> None:
        """Do nothing, as nothing is connected."""
