"""A camera of a cell by its name on the command line."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.cell.sensors.mounted_camera import MountedCamera


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
