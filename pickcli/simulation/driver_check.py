"""Test of a driver against the protocol: it stands, carries out a plan, and its answers are checked."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.device import DeviceKind
from pickcli.cell.tool import ToolState
from pickcli.errors import UnknownNameError
from pickcli.geometry import Array
from pickcli.kinematics.continuous_joints import unwound_towards
from pickcli.motion.plan import Plan
from pickcli.simulation.drive import drive
from pickcli.simulation.driver import Driver
from pickcli.simulation.guarded_driver import period_fault
from pickcli.simulation.plan_record import PlanRecord
from pickcli.simulation.start_check import START_TOLERANCE, check_start

STANDING_TIME = 0.2  # s during which it is commanded to stand
LEAST_STEPS = 20
PERIOD_TOLERANCE = 0.1  # of the period, on average
EVENT_TOLERANCE = 0.01  # m of tool path between an event and its trigger
NO_SUCH = "no such name"


@dataclass(frozen=True)
class DriverCheck:
    """Result of one check of a driver.

    Attributes:
        what: The requirement.
        fault: The violation; "" without one.
        is_tried: Whether it was checked: after a fault nothing moves any more.
    """

    what: str
    fault: str = ""
    is_tried: bool = True

    @property
    def is_passed(self) -> bool:
        """Whether the driver meets the requirement."""
        return self.is_tried and not self.fault


@dataclass(frozen=True)
class DriverReport:
    """Results of all checks of a driver.

    Attributes:
        checks: Results in their order.
        record: Record of the plan's execution; None if it did not begin.
    """

    checks: tuple[DriverCheck, ...]
    record: PlanRecord | None = None

    @property
    def is_passed(self) -> bool:
        """Whether the driver keeps to the protocol."""
        return all(check.is_passed for check in self.checks)


def check_driver(driver: Driver, plan: Plan) -> DriverReport:
    """Check that a driver keeps to the protocol. It carries out the plan: the robot moves.

    Args:
        driver: The driver. It is closed at the end.
        plan: A plan that is verified for the real surroundings and begins where the robot stands.

    Returns:
        The result of every check. Checks after a failed one are not tried.
    """
    session = _Session(driver, plan, _Watched(driver))
    checks: list[DriverCheck] = []
    for what, find_fault in _CHECKS:
        if all(check.is_passed for check in checks):
            checks.append(DriverCheck(what, _fault(find_fault, session)))
        else:
            checks.append(DriverCheck(what, is_tried=False))
    checks.append(DriverCheck("it is closed, also twice", _fault(_close, session)))
    return DriverReport(tuple(checks), session.record)


class _Watched:
    """Wrapper around the checked driver that records its answers.

    It passes all set points in the same array, and overwrites that with the measured configuration before the
    step: a driver that keeps the array instead of copying it does not move.
    """

    def __init__(self, driver: Driver) -> None:
        self._driver = driver
        self._point: Array | None = None
        self.answers: list[tuple[str, bool | None]] = []
        self.n_steps = 0
        self.set_back = ""  # the first step after which it is no later than before

    @property
    def cell(self) -> Cell:
        return self._driver.cell

    @property
    def time_step(self) -> float:
        return self._driver.time_step

    @property
    def t(self) -> float:
        return self._driver.t

    @property
    def q(self) -> Array:
        return self._driver.q

    @property
    def tool_state(self) -> ToolState:
        return self._driver.tool_state

    def command(self, q: Array) -> None:
        if self._point is None:
            self._point = np.array(q, dtype=float)
        self._point[:] = q
        self._driver.command(self._point)
        self._point[:] = self._driver.q

    def act(self, device: str, action: str) -> bool | None:
        answer = self._driver.act(device, action)
        self.answers.append((device, answer))
        return answer

    def step(self) -> None:
        before = self._driver.t
        self._driver.step()
        self.n_steps += 1
        if not self._driver.t > before and not self.set_back:
            self.set_back = f"t was {before:.6g} and is {self._driver.t:.6g} after a step"

    def close(self) -> None:
        self._driver.close()


@dataclass
class _Session:
    """State shared by the checks."""

    driver: Driver
    plan: Plan
    watched: _Watched
    record: PlanRecord | None = field(default=None)


def _fault(find_fault: Callable[[_Session], str], session: _Session) -> str:
    """Run a check; exceptions of the driver are faults, too."""
    try:
        return find_fault(session)
    except (Exception, SystemExit) as error:
        return f"{type(error).__name__}: {error}"


def _period(session: _Session) -> str:
    return period_fault(session.driver.time_step)


def _configuration(session: _Session) -> str:
    driver = session.driver
    q, limits = driver.q, driver.cell.robot.limits
    n = driver.cell.robot.n_joints
    if not isinstance(q, np.ndarray) or q.shape != (n,) or q.dtype != np.float64:
        return f"q is no array of {n} floats"
    if not np.isfinite(q).all():
        return "q is not finite"
    outside = np.maximum(limits.lower - q, q - limits.upper)
    worst = int(outside.argmax())
    return (
        f"{driver.cell.robot.joint_names[worst]} is beyond its limits"
        if outside[worst] > START_TOLERANCE
        else ""
    )


def _start(session: _Session) -> str:
    check_start(session.plan, session.driver)
    return ""


def _unknown_names(session: _Session) -> str:
    pairs = [(NO_SUCH, "on"), *((name, NO_SUCH) for name in session.driver.cell.devices)]
    for device, action in pairs:
        with suppress(UnknownNameError):
            session.driver.act(device, action)
            return f"act({device!r}, {action!r}) was taken, UnknownNameError expected"
    return ""


def _sensors(session: _Session) -> str:
    for device in session.driver.cell.devices.values():
        if device.kind is DeviceKind.SENSOR:
            answer = session.driver.act(device.name, device.actions[0])
            if not isinstance(answer, bool):
                return f"{device.name} answers {answer!r}, True or False expected"
    return ""


def _standing(session: _Session) -> str:
    driver = session.driver
    begun = driver.q
    before, copy = begun, begun.copy()
    driver.command(begun.copy())
    for _ in _steps(session):
        if (moved := float(np.abs(driver.q - copy).max())) > START_TOLERANCE:
            return f"a joint moved by {moved:.4f} while commanded to stand"
    return "" if np.array_equal(before, copy) else "an array that q returned was changed afterwards"


def _clock(session: _Session) -> str:
    driver, n_steps = session.driver, session.watched.n_steps
    began = driver.t
    for _ in _steps(session):
        pass
    mean = (driver.t - began) / (session.watched.n_steps - n_steps)
    return session.watched.set_back or _wrong_pace(mean, driver.time_step)


def _steps(session: _Session) -> Iterator[None]:
    for _ in range(max(LEAST_STEPS, round(STANDING_TIME / session.driver.time_step))):
        session.watched.step()
        yield


def _wrong_pace(mean: float, period: float) -> str:
    if abs(mean - period) <= PERIOD_TOLERANCE * period:
        return ""
    return f"a step takes {mean:.5f} s on average, its time_step is {period:.5f} s"


def _carries_out(session: _Session) -> str:
    watched, plan = session.watched, session.plan
    watched.n_steps = 0
    session.record = record = drive(plan, watched)
    if record.trouble:
        kept = ", or keeps the array of its set point" if record.stop is not None else ""
        return f"{record.trouble}{kept}"
    end = plan.trajectory.positions[-1]
    robot = watched.cell.robot
    off = np.abs(watched.q - unwound_towards(robot.limits, end, watched.q))
    worst = int(off.argmax())
    if off[worst] <= START_TOLERANCE:
        return ""
    return f"{robot.joint_names[worst]} ends {off[worst]:.4f} from the plan's last point"


def _pace(session: _Session) -> str:
    record = session.record
    if record is None or not session.watched.n_steps:
        return "nothing was executed"
    return session.watched.set_back or _wrong_pace(
        record.duration / session.watched.n_steps, session.watched.time_step
    )


def _events(session: _Session) -> str:
    record = session.record
    far = [fired for fired in (record.events if record else ()) if fired.distance > EVENT_TOLERANCE]
    if not far:
        return ""
    return f"{far[0].event.device} {far[0].event.action} came {1e3 * far[0].distance:.1f} mm from its place"


def _answers(session: _Session) -> str:
    devices = session.watched.cell.devices
    for name, answer in session.watched.answers:
        is_sensor = devices[name].kind is DeviceKind.SENSOR
        if is_sensor != isinstance(answer, bool) or (not is_sensor and answer is not None):
            return f"{name} answers {answer!r}"
    return ""


def _close(session: _Session) -> str:
    session.driver.close()
    session.driver.close()
    return ""


_CHECKS: tuple[tuple[str, Callable[[_Session], str]], ...] = (
    ("its period is that of a stream", _period),
    ("it measures a configuration of the cell", _configuration),
    ("it stands at the start of the plan", _start),
    ("it refuses devices and actions that the cell does not have", _unknown_names),
    ("its sensors answer yes or no", _sensors),
    ("it stands when commanded to", _standing),
    ("its clock runs with its steps", _clock),
    ("it executes the plan and arrives", _carries_out),
    ("its clock runs with its steps while it moves", _pace),
    ("its measurements let events fire in their places", _events),
    ("its devices answer as the protocol says", _answers),
)
