"""--scene and --cell of the commands that work in a scene."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from pickcli.cell.scene import Scene

F = TypeVar("F", bound=Callable[..., Any])


def scene_options(function: F) -> F:
    """--scene FILE and --cell NAME|DIR."""
    function = click.option(
        "--cell", "cell_name", metavar="NAME|DIR",
        help="The scene's cell.  [default: the one under data/cells that it names]",
    )(function)  # fmt: skip
    return click.option(
        "--scene", "scene_path", type=click.Path(path_type=Path), metavar="FILE", required=True,
        help="Scene file (see apc make-scene).",
    )(function)  # fmt: skip


def open_scene(path: Path, cell_name: str | None) -> Scene:
    """The scene in a file, of the named cell if one is named. Raises InputError, StaleError."""
    from pickcli.cell.load import load_cell
    from pickcli.cell.scene_file import read_scene

    return read_scene(path, None if cell_name is None else load_cell(cell_name))
