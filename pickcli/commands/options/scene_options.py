"""Options --scene and --cell of the commands that work in a scene."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pickcli.commands.logs import stage
from pickcli.commands.options.arm_options import ArmRequest, open_cell
from pickcli.commands.options.common_options import CELL_HELP, items_option
from pickcli.commands.options.option_types import PATH
from pickcli.errors import InputError

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.scene.scene import Scene

NO_ARM = ArmRequest()

F = TypeVar("F", bound=Callable[..., Any])


def scene_options(function: F) -> F:
    """Give a command the options --scene FILE (required), --cell NAME|FOLDER and --items.

    Args:
        function: The command.

    Returns:
        The command with the options.
    """
    function = _cell_option(items_option(function))
    return click.option(
        "--scene", "scene_path", type=PATH, metavar="FILE", required=True,
        help="Scene file (see apc make-scene).",
    )(function)  # fmt: skip


def scene_or_cell_options(function: F) -> F:
    """Give a command the options --scene FILE and --cell NAME|FOLDER, one of which is required, and --items.

    Args:
        function: The command.

    Returns:
        The command with the options.
    """
    return _optional_scene(function, "the empty cell of --cell")


def scene_or_recorded_options(function: F) -> F:
    """Give a command the options --scene FILE, --cell NAME|FOLDER and --items; recordings need no scene.

    Args:
        function: The command, which has an option --recorded.

    Returns:
        The command with the options.
    """
    return _optional_scene(function, "with --recorded the empty cell of --cell")


def _optional_scene(function: F, default: str) -> F:
    function = _cell_option(items_option(function))
    return click.option(
        "--scene", "scene_path", type=PATH, metavar="FILE",
        help=f"Scene file (see apc make-scene).  [default: {default}]",
    )(function)  # fmt: skip


def _cell_option(function: F) -> F:
    return click.option(
        "--cell", "cell_name", metavar="NAME|FOLDER",
        help=f"{CELL_HELP}  [default: the one that the scene names]",
    )(function)  # fmt: skip


def scene_or_empty(path: Path | None, cell_name: str | None, arms: ArmRequest = NO_ARM) -> Scene:
    """Read a scene, or make the empty scene of a cell.

    Args:
        path: The file; None for the empty cell.
        cell_name: Name or folder of the cell; None for the one that the scene names.
        arms: The arms stated on the command line.

    Returns:
        The scene.

    Raises:
        UsageError: Neither is named.
        InputError: The file or the cell cannot be read.
        StaleError: The scene was made for another cell.
    """
    from pickcli.scene.scene import empty_scene

    if path is not None:
        return open_scene(path, cell_name, arms)
    if cell_name is None:
        raise click.UsageError("no surroundings: name a scene with --scene, or an empty cell with --cell")
    with stage("reading of the cell"):
        return empty_scene(open_cell(cell_name, arms))


def open_scene(path: Path, cell_name: str | None, arms: ArmRequest = NO_ARM) -> Scene:
    """Read a scene.

    If its pod is beyond the cell's bounds, a note explains the consequences.

    Args:
        path: The file.
        cell_name: Name or folder of the cell that it must belong to; None for the one that it names.
        arms: The arms stated on the command line.

    Returns:
        The scene.

    Raises:
        InputError: The file or the cell cannot be read.
        StaleError: It was made for another cell.
    """
    from pickcli.cell.pod_tolerance import pod_stand
    from pickcli.scene.scene_file import read_scene
    from pickcli.statics.balance_warning import warn_of_motion

    with stage("reading of the scene"):
        cell = None if cell_name is None else _cell_of_scene(path, cell_name, arms)
        scene = read_scene(path, cell, partial(open_cell, request=arms), warn_of_motion)
    if not scene.is_pod_within_bounds:
        click.echo(
            f"note: {path}: the pod stands {pod_stand(scene.T_nominal_pod)}, "
            f"the cell allows for {allowed(scene.cell)}: stored motions may not be free there; each is "
            "proven before it is used, and planned again if that fails",
            err=True,
        )
    return scene


def _cell_of_scene(path: Path, cell_name: str, arms: ArmRequest) -> Cell:
    """Load the cell of a scene; that the scene is of another cell is told before what is wrong with arms."""
    from pickcli.cell.cell_file import load_workcell
    from pickcli.scene.scene_file import read_scene

    workcell = load_workcell(cell_name, arms.items)
    try:
        return arms.cell_of(workcell)
    except InputError:
        read_scene(path, workcell.preferred)
        raise


def refuse_held(scene: Scene, path: Path | None) -> None:
    """Refuse a scene with a held item for a command that needs an empty tool.

    Args:
        scene: The scene.
        path: Its file, for the message; None for a scene without a file.

    Raises:
        InputError: The scene has a held item.
    """
    if scene.held is not None:
        raise InputError(
            f"{path}: held: {scene.held.id} is in the cup, and this command begins with an empty one; put "
            "the item where it lies and plan from there"
        )


def allowed(cell: Cell) -> str:
    """Describe how far the pod may be from its nominal pose.

    Args:
        cell: The cell.

    Returns:
        The text, in mm and degrees.
    """
    bounds = cell.pod.displacement
    return f"{1e3 * bounds.x:.1f} mm, {1e3 * bounds.y:.1f} mm and {degrees(bounds.yaw):.2f} degrees"
