"""Configurations in scripts: one of the cell's by its name, or one number per joint."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import TypeAlias

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.robot import Robot
from pickcli.cell.tool import ToolState
from pickcli.errors import InputError, UnknownNameError
from pickcli.geometry import Array
from pickcli.planning.start_state import Start

FULL_TURN = 6.3  # rad: a larger position is probably in degrees
MAX_PLAUSIBLE_POSITION = 20.0  # m, beyond any rail: a larger position is probably in mm

# A name of one of the cell's configurations, or (n,) numbers in m and rad.
Configuration: TypeAlias = str | Sequence[float] | Array


def start_of(cell: Cell, configuration: Configuration, tool_state: str | None = None) -> Start:
    """Return the state of the robot at rest in a configuration.

    Args:
        cell: The cell.
        configuration: Configuration of the robot.
        tool_state: Name of its tool state; None for the one that the named configuration is meant for, or the
            tool's default.

    Returns:
        The state.

    Raises:
        UnknownNameError: The cell has no such configuration, or its tool no such state.
        InputError: The numbers are not a configuration within the joint limits.
    """
    tool = cell.robot.tool
    if tool_state is not None:
        return Start(values_of(cell, configuration), state_named(cell, tool_state))
    if isinstance(configuration, str) and configuration in cell.configurations:
        return Start(values_of(cell, configuration), cell.configurations[configuration].tool_state)
    return Start(values_of(cell, configuration), tool.default_state)


def goals_of(cell: Cell, goals: Configuration | Sequence[Configuration]) -> list[Array]:
    """Return the configurations of one goal or of several.

    Args:
        cell: The cell.
        goals: One configuration, or several.

    Returns:
        (n,) each.

    Raises:
        UnknownNameError: The cell has no such configuration.
        InputError: Numbers are not a configuration within the joint limits, or there is no goal.
    """
    if len(goals) == 0:
        raise InputError("no goal is named; name a configuration, or several")
    is_one = isinstance(goals, str) or isinstance(goals[0], float | int | np.floating | np.integer)
    return [values_of(cell, each) for each in ((goals,) if is_one else goals)]  # type: ignore[arg-type]


def values_of(cell: Cell, configuration: Configuration) -> Array:
    """Return the joint positions of a configuration.

    Args:
        cell: The cell.
        configuration: Its name, or its joint positions.

    Returns:
        (n,) m and rad.

    Raises:
        UnknownNameError: The cell has no such configuration.
        InputError: The numbers are not a configuration within the joint limits.
    """
    if isinstance(configuration, str):
        if configuration not in cell.configurations:
            raise UnknownNameError("configuration", configuration, list(cell.configurations))
        return cell.configurations[configuration].q
    q, names = np.asarray(configuration, dtype=np.float64), cell.robot.joint_names
    if q.shape != (len(names),):
        raise InputError(f"configuration: expected {len(names)} numbers ({', '.join(names)}), got {q.shape}")
    refuse_beyond_limits(cell.robot, q, "configuration")
    return q


def state_named(cell: Cell, name: str) -> ToolState:
    """Return the state of a cell's tool with a given name.

    Args:
        cell: The cell.
        name: The name.

    Returns:
        The state.

    Raises:
        UnknownNameError: The tool has no such state.
    """
    names = {state.name: state for state in cell.robot.tool.states}
    if name not in names:
        raise UnknownNameError("state of the tool", name, list(names))
    return names[name]


def refuse_beyond_limits(robot: Robot, q: Array, what: str) -> None:
    """Refuse positions beyond the joint limits; the message suggests the unit that was probably meant.

    Args:
        robot: The robot.
        q: (n,) m and rad.
        what: Name of the positions in the message.

    Raises:
        InputError: A joint is beyond its limits.
    """
    faults = []
    for i, (name, unit) in enumerate(zip(robot.joint_names, robot.units, strict=True)):
        low, high = robot.limits.lower[i], robot.limits.upper[i]
        if not low <= q[i] <= high:  # nan is in no range
            faults.append(f"{name} is {q[i]:g} {unit}, its limits are {low:g} to {high:g} {unit}")
    if faults:
        raise InputError(f"{what}: {'; '.join(faults)}; {_unit_advice(robot, q)}")


def _unit_advice(robot: Robot, q: Array) -> str:
    """Return advice for a configuration (n,) beyond its limits: far beyond, it is probably in other units."""
    units = np.array(robot.units)
    angle, length = (float(np.abs(q[units == unit]).max(initial=0.0)) for unit in ("rad", "m"))
    if FULL_TURN < angle < inf:
        return "angles are in rad, not degrees"
    return "lengths are in m, not mm" if MAX_PLAUSIBLE_POSITION < length < inf else "correct it"
