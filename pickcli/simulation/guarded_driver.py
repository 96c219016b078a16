"""Wrapper around installed drivers that turns their exceptions and invalid answers into clear errors.

``check_driver`` finds such faults beforehand; others, such as a pulled cable, occur only during execution.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.device import DeviceKind
from pickcli.cell.tool import ToolState
from pickcli.errors import ApcError, InputError
from pickcli.geometry import Array
from pickcli.simulation.belt_clock import BeltEncoder
from pickcli.simulation.driver import Driver, DriverFactory, DriverRequest

Answer = TypeVar("Answer")

SHORTEST_PERIOD = 1e-4  # s between set points, limit of streaming here
LONGEST_PERIOD = 0.1  # s; robots do not follow less frequent set points


def period_fault(period: object) -> str:
    """Check the period of a driver's set points.

    Args:
        period: s, as the driver states it.

    Returns:
        The fault; "" without one.
    """
    if isinstance(period, float) and SHORTEST_PERIOD <= period <= LONGEST_PERIOD:
        return ""
    return f"time_step is {period}, {SHORTEST_PERIOD:g} to {LONGEST_PERIOD:g} s expected"


def connected(name: str, connect: DriverFactory, request: DriverRequest) -> Driver:
    """Create a driver.

    Args:
        name: Name of the driver.
        connect: Function that creates it.
        request: Parameters for creating it.

    Returns:
        The driver.

    Raises:
        InputError: The driver could not be created.
    """
    return _guarded(name, lambda: connect(request))


class GuardedDriver:
    """A driver whose failures end a run with a single error, never by a hang or an invalid array.

    Args:
        name: Name of the driver.
        driver: The driver.

    Raises:
        InputError: Its period is not valid for streaming.
    """

    def __init__(self, name: str, driver: Driver) -> None:
        self._name, self._driver, self._has_failed = name, driver, False
        self._n_joints = self._guarded_call(lambda: driver.cell.robot.n_joints)
        self._time_step = self._guarded_call(lambda: driver.time_step)
        if fault := period_fault(self._time_step):
            raise self._failure(fault)

    @property
    def cell(self) -> Cell:
        """The cell as seen by the moving arm."""
        return self._driver.cell

    @property
    def time_step(self) -> float:
        """Period of the set points, s."""
        return self._time_step

    @property
    def t(self) -> float:
        """Time since an arbitrary moment before the first step, s, finite."""
        t = self._guarded_call(lambda: float(self._driver.t))
        if not math.isfinite(t):
            raise self._failure(f"t is {t}")
        return t

    @property
    def q(self) -> Array:
        """Measured configuration (n,), finite."""
        q = self._guarded_call(lambda: self._driver.q)
        if not isinstance(q, np.ndarray) or q.shape != (self._n_joints,) or q.dtype != np.float64:
            raise self._failure(f"q is no array of {self._n_joints} floats")
        if not np.isfinite(q).all():
            raise self._failure("q is not finite")
        return q

    @property
    def tool_state(self) -> ToolState:
        """Current state of the tool."""
        return self._guarded_call(lambda: self._driver.tool_state)

    def command(self, q: Array) -> None:
        """Set the target configuration at the end of the next step.

        Args:
            q: (n,) configuration.
        """
        self._guarded_call(lambda: self._driver.command(q))

    def act(self, device: str, action: str) -> bool | None:
        """Switch a device, or read a sensor.

        Args:
            device: Name of a device of the cell.
            action: One of its actions.

        Returns:
            A sensor's reading; None for other devices.
        """
        answer = self._guarded_call(lambda: self._driver.act(device, action))
        is_sensor = self.cell.devices[device].kind is DeviceKind.SENSOR
        if is_sensor and not isinstance(answer, bool):
            raise self._failure(f"sensor {device} answers {answer!r}, True or False expected")
        return answer

    def belt_travel(self, conveyor: str) -> float | None:
        """Return the measured travel of a conveyor.

        Args:
            conveyor: Name of the conveyor.

        Returns:
            m, finite; None if the driver has no encoder of it.
        """
        driver = self._driver
        if not isinstance(driver, BeltEncoder):
            return None
        travel = self._guarded_call(lambda: driver.belt_travel(conveyor))
        return None if travel is None else self._finite(travel, f"the travel of {conveyor}")

    def encoder_latency(self, conveyor: str) -> float:
        """Return by how much a reading of the encoder of a conveyor is old.

        Args:
            conveyor: Name of the conveyor.

        Returns:
            s, finite; 0 if the driver has no encoder.
        """
        driver = self._driver
        if not isinstance(driver, BeltEncoder):
            return 0.0
        latency = self._guarded_call(lambda: driver.encoder_latency(conveyor))
        return self._finite(latency, f"the latency of the encoder of {conveyor}")

    def _finite(self, value: object, what: str) -> float:
        """Return a number that the driver measured. Raises InputError for anything else."""
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise self._failure(f"{what} is {value!r}, a finite number expected")
        return float(value)

    def step(self) -> None:
        """Wait for one period, in which the driver's time must increase."""
        before = self.t
        self._guarded_call(self._driver.step)
        if not self.t > before:
            raise self._failure(f"t was {before} and is {self.t} after a step")

    def close(self) -> None:
        """Close the driver. After a fault further exceptions are ignored: the first one counts."""
        if not self._has_failed:
            self._guarded_call(self._driver.close)
            return
        try:
            self._driver.close()
        except (Exception, SystemExit):
            return

    def _guarded_call(self, call: Callable[[], Answer]) -> Answer:
        try:
            return _guarded(self._name, call)
        except ApcError:
            self._has_failed = True
            raise

    def _failure(self, fault: str) -> InputError:
        self._has_failed = True
        return _failure(self._name, fault)


def _guarded(name: str, call: Callable[[], Answer]) -> Answer:
    """Call a driver. Raises InputError for exceptions that are not an ApcError."""
    try:
        return call()
    except ApcError:
        raise
    except (Exception, SystemExit) as error:
        raise _failure(name, f"{type(error).__name__}: {error}") from error


def _failure(name: str, fault: str) -> InputError:
    return InputError(
        f"driver {name}: {fault}; no more set points are sent to the robot: make sure that it is at rest, "
        f"then try apc check-driver {name}"
    )
