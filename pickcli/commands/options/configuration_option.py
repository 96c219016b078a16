"""Configurations on the command line: the name of a configuration of the cell, or numbers."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pickcli.errors import InputError, UnknownNameError
from pickcli.name_suggestion import shortened, suggestion

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.cell.tool import ToolState
    from pickcli.geometry import Array
    from pickcli.motion.plan import Plan
    from pickcli.planning.start_state import Start
    from pickcli.scene.scene import Scene

F = TypeVar("F", bound=Callable[..., Any])

CONFIGURATION = "NAME|q"
CONFIGURATION_HELP = (
    "a configuration of the cell (apc inspect lists them), or joint positions with commas, rad and m."
)


def start_option(function: F) -> F:
    """Give a command the option --from NAME|q, by default home.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--from", "start", metavar=CONFIGURATION, default="home", show_default=True,
        help=f"Start of the robot: {CONFIGURATION_HELP}",
    )(function)  # fmt: skip


def tool_state_option(function: F) -> F:
    """Give a command the option --tool-state STATE.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--tool-state", metavar="STATE", default=None, show_default="the first of the cell",
        help="State of the tool at the poses, e.g. straight.",
    )(function)  # fmt: skip


def parse_configuration(cell: Cell, text: str) -> tuple[Array, ToolState | None]:
    """Parse a configuration: a name in the cell, or n numbers with commas.

    Args:
        cell: The cell.
        text: Text from the command line.

    Returns:
        Configuration (n,) in rad and m, and the tool state; None for numbers, which do not include it.

    Raises:
        InputError: The name is unknown, or the numbers are not a configuration within the joint limits.
    """
    if text in cell.configurations:
        named = cell.configurations[text]
        return named.q, named.tool_state
    from pickcli.api.configurations import refuse_beyond_limits

    q = _numbers(cell, text)
    refuse_beyond_limits(cell.robot, q, f"configuration {text!r}")
    return q, None


def parse_start(cell: Cell, text: str) -> Start:
    """Parse the state of the robot before a motion, with the default tool state for numbers.

    Args:
        cell: The cell.
        text: Text from the command line.

    Returns:
        Configuration and tool state.

    Raises:
        InputError: As ``parse_configuration``.
    """
    from pickcli.planning.start_state import Start

    q, tool_state = parse_configuration(cell, text)
    return Start(q, tool_state or cell.robot.tool.default_state)


def _numbers(cell: Cell, text: str) -> Array:
    """Parse a configuration (n,) written as numbers. Raises InputError, also for an unknown name."""
    import numpy as np

    names = cell.robot.joint_names
    how = f"write {len(names)} numbers with commas ({','.join(names)})"
    if not re.search(r"^[-+.\d]|[,;]", text):
        known, hint = list(cell.configurations), suggestion(text, cell.configurations)
        if hint.startswith("known"):
            hint = f"apc inspect {cell.name} lists the names; or {how}"
        raise UnknownNameError("configuration", text, known, hint=hint)
    parts, name = text.split(","), f"configuration {shortened(text)!r}"
    for part in parts:
        if not _is_number(part):
            raise InputError(f"{name}: {shortened(part)!r} is not a number; {how}")
    if len(parts) != len(names):
        raise InputError(
            f"configuration {shortened(text)!r}: got {len(parts)} of {len(names)} numbers; {how}"
        )
    return np.array([float(part) for part in parts])


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def start_state_of(plan: Plan, scene: Scene, start: str | None) -> tuple[Array, ToolState]:
    """Return the state of the robot before a plan is executed.

    Args:
        plan: The plan.
        scene: The scene.
        start: Configuration from the command line; None for the start of the plan.

    Returns:
        Configuration (n,) and tool state: as requested, else those at the start of the plan.

    Raises:
        InputError: The cell has no such configuration.
    """
    from pickcli.cell.tool import MOVING

    first, tool = plan.segments[0].tool_state, scene.cell.robot.tool
    at_start = tool.default_state if first == MOVING else first
    if start is None:
        return plan.trajectory.positions[0], at_start
    q, tool_state = parse_configuration(scene.cell, start)
    return q, tool_state or at_start


def named_state(cell: Cell, text: str | None) -> ToolState:
    """Find a state of the cell's tool by its name.

    Args:
        cell: The cell.
        text: The name; None for the default state.

    Returns:
        The state.

    Raises:
        UnknownNameError: The tool has no such state.
    """
    from pickcli.api.configurations import state_named

    return cell.robot.tool.default_state if text is None else state_named(cell, text)
