"""A driver of another package as it carries out a plan: what it raises or answers amiss is told as its own.

``check_driver`` finds such faults beforehand; a cable that is pulled comes later.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.tool import ToolState
from pickcli.errors import ApcError, InputError
from pickcli.geometry import Array
from pickcli.simulation.driver import Driver, DriverFactory, DriverRequest

Answer = TypeVar("Answer")

SHORTEST_PERIOD = 1e-4  # s between set points: nothing is streamed faster from here
LONGEST_PERIOD = 0.1  # s: a robot that is told its way more rarely does not follow it


def period_fault(period: object) -> str:
    """Tell what is wrong with the period of a driver's set points.

    Args:
        period: s, as the driver states it.

    Returns:
        The fault; "" if there is none.
    """
    if isinstance(period, float) and SHORTEST_PERIOD <= period <= LONGEST_PERIOD:
        return ""
    return f"time_step is {period}, {SHORTEST_PERIOD:g} to {LONGEST_PERIOD:g} s expected"


def connected(name: str, connect: DriverFactory, request: DriverRequest) -> Driver:
    """Make a driver.

    Args:
        name: What it is called.
        connect: Makes it.
        request: What it is made for.

    Returns:
        The driver.

    Raises:
        InputError: It could not be made.
    """
    return _asked(name, lambda: connect(request))


class GuardedDriver:
    """A driver that ends a run by one message where it fails, and never by a hang or a wrong array.

    Args:
        name: What it is called.
        driver: The driver.

    Raises:
        InputError: Its period is none of a stream.
    """

    def __init__(self, name: str, driver: Driver) -> None:
        self._name, self._driver, self._has_failed = name, driver, False
        self._n_joints = self._ask(lambda: driver.cell.robot.n_joints)
        self._time_step = self._ask(lambda: driver.time_step)
        if fault := period_fault(self._time_step):
            raise self._failure(fault)

    @property
    def cell(self) -> Cell:
        """The cell, as the arm that moves sees it."""
        return self._driver.cell

    @property
    def time_step(self) -> float:
        """Period of the set points, s."""
        return self._time_step

    @property
    def t(self) -> float:
        """Time since any moment before the first step, s, finite."""
        t = self._ask(lambda: float(self._driver.t))
        if not math.isfinite(t):
            raise self._failure(f"t is {t}")
        return t

    @property
    def q(self) -> Array:
        """Measured configuration (n,), finite."""
        q = self._ask(lambda: self._driver.q)
        if not isinstance(q, np.ndarray) or q.shape != (self._n_joints,) or q.dtype != np.float64:
            raise self._failure(f"q is no array of {self._n_joints} floats")
        if not np.isfinite(q).all():
            raise self._failure("q is not finite")
        return q

    @property
    def tool_state(self) -> ToolState:
        """State of the tool as it stands."""
        return self._ask(lambda: self._driver.tool_state)

    def command(self, q: Array) -> None:
        """Set where the robot is to be at the end of the next step.

        Args:
            q: (n,) configuration.
        """
        self._ask(lambda: self._driver.command(q))

    def act(self, device: str, action: str) -> bool | None:
        """Switch a device, or read a sensor.

        Args:
            device: Name of a device of the cell.
            action: One of its actions.

        Returns:
            A sensor's answer; None for other devices.
        """
        return self._ask(lambda: self._driver.act(device, action))

    def step(self) -> None:
        """Let one period pass, in which time goes on."""
        before = self.t
        self._ask(self._driver.step)
        if not self.t > before:
            raise self._failure(f"t was {before} and is {self.t} after a step")

    def close(self) -> None:
        """Let go of everything. After a fault nothing more is told: the first one counts."""
        if not self._has_failed:
            self._ask(self._driver.close)
            return
        try:
            self._driver.close()
        except (Exception, SystemExit):
            return

    def _ask(self, call: Callable[[], Answer]) -> Answer:
        try:
            return _asked(self._name, call)
        except ApcError:
            self._has_failed = True
            raise

    def _failure(self, fault: str) -> InputError:
        self._has_failed = True
        return _failure(self._name, fault)


def _asked(name: str, call: Callable[[], Answer]) -> Answer:
    """What a driver answers. Raises InputError for all that it raises and that is none of our errors."""
    try:
        return call()
    except ApcError:
        raise
    except (Exception, SystemExit) as error:
        raise _failure(name, f"{type(error).__name__}: {error}") from error


def _failure(name: str, fault: str) -> InputError:
    return InputError(
        f"driver {name}: {fault}; nothing more is sent to the robot: see that it stands, then try "
        f"apc check-driver {name}"
    )
