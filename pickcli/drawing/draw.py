"""Draws cells and stored files."""

from __future__ import annotations

from pathlib import Path

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import cell_names, load_workcell
from pickcli.drawing.picture import Picture
from pickcli.drawing.stored import database_picture, roadmap_picture
from pickcli.errors import InputError
from pickcli.files.atomic_write import write_bytes
from pickcli.roadmap.roadmap_tables import ROADMAP
from pickcli.roadmap.store import kind_of, read_database, read_gaps, read_missing, read_roadmap

SUFFIXES = (".png", ".html")


def refuse_suffix(output: Path) -> None:
    """Refuse, before any work, an unknown format of pictures.

    Args:
        output: The picture's file.

    Raises:
        InputError: The suffix is not one of SUFFIXES.
    """
    if output.suffix.lower() not in SUFFIXES:
        raise InputError(f"{output}: a picture is written as {' or '.join(SUFFIXES)}; name such a file")


def write_png(picture: Picture, output: Path, replace: bool = True) -> None:
    """Write a picture as a PNG.

    Args:
        picture: The picture.
        output: The picture's file.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written.
    """
    from pickcli.drawing.png import png_bytes  # slow to import

    write_bytes(output, png_bytes(picture), replace)


def picture_of(stored: Path, cell: Cell) -> Picture:
    """Draw a stored file.

    Args:
        stored: File of a roadmap or database.
        cell: The cell that it was made for.

    Returns:
        The picture.

    Raises:
        StaleError: The file was made for another cell.
        InputError: It cannot be read.
    """
    if kind_of(stored) is ROADMAP:
        return roadmap_picture(cell, read_roadmap(stored, cell), read_gaps(stored))
    return database_picture(cell, read_database(stored, cell), read_missing(stored))


def cell_of(fingerprint: str) -> Cell:
    """Find the cell under data/cells with a fingerprint.

    Args:
        fingerprint: Hexadecimal digits.

    Returns:
        The cell.

    Raises:
        InputError: No cell has it.
    """
    cells = [cell for name in cell_names() for cell in load_workcell(name).arms.values()]
    for cell in cells:
        if cell.fingerprint == fingerprint:
            return cell
    raise InputError(
        f"no cell under data/cells has the fingerprint {fingerprint}; name the one of this file with --cell"
    )
