"""A camera of a cell by its name on the command line, and where the arm is as it looks."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pickcli.commands.configuration_option import CONFIGURATION, CONFIGURATION_HELP

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.cell.sensors.mounted_camera import MountedCamera


F = TypeVar("F", bound=Callable[..., Any])


def camera_options(function: F) -> F:
    """Give a command the options --camera NAME and --at CONFIGURATION.

    Args:
        function: The command.

    Returns:
        The command with the options.
    """
    at = click.option(
        "--at", metavar=CONFIGURATION, default="home", show_default=True,
        help=f"Where the arm is: {CONFIGURATION_HELP}",
    )  # fmt: skip
    camera = click.option(
        "--camera", "name", metavar="NAME", required=True,
        help="A camera under sensors of the cell (apc inspect lists them).",
    )  # fmt: skip
    return camera(at(function))


def named_camera(cell: Cell, name: str) -> MountedCamera:
    """Find a camera.

    Args:
        cell: The cell.
        name: Its name there.

    Returns:
        The camera.

    Raises:
        InputError: The cell has no cameras.
        UnknownNameError: It has others.
    """
    from pickcli.errors import InputError, UnknownNameError

    if not cell.cameras:
        raise InputError(
            f"cell {cell.name}: has no cameras; add one under sensors in {cell.path / 'cell.yaml'} "
            "(docs/formats/cell.md)"
        )
    if name not in cell.cameras:
        raise UnknownNameError("camera", name, list(cell.cameras), f"cell {cell.name}")
    return cell.cameras[name]
