"""Pages of drawings: tool paths through a cell, named points, and bar charts for its places."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from pickcli.cell.cell import Cell
from pickcli.drawing.draw import refuse_suffix, write_png
from pickcli.drawing.picture import Coverage, Picture
from pickcli.files.atomic_write import write_bytes
from pickcli.files.packed_array import packed
from pickcli.page.html_page import page_bytes
from pickcli.page.page_document import Bar, Chart, PageDocument
from pickcli.page.page_scene import Fact, PageLine, PageNode, rounded
from pickcli.page.scene_page import cell_page

POINT_RESOLUTION = 1e-3  # m, resolution of path points


def picture_page(picture: Picture, cell: Cell, kind: str) -> PageDocument:
    """Create the page of a drawing.

    Args:
        picture: The drawing.
        cell: The cell of the drawing.
        kind: Kind of the page.

    Returns:
        The page.
    """
    title, _, more = picture.title.partition(": ")
    base = cell_page(cell)
    return replace(
        base,
        kind=kind,
        title=title,
        subtitle=more or base.subtitle,
        facts=tuple(Fact("", words) for words in picture.words),
        nodes=tuple(
            PageNode(node.name, rounded(node.place), str(node.ink), node.is_main) for node in picture.nodes
        ),
        lines=tuple(
            PageLine(line.name, packed(line.points, POINT_RESOLUTION), str(line.ink))
            for line in picture.lines[1:]
        ),
        legend=tuple((name, str(ink)) for name, ink in picture.lines_by_ink),
        charts=(_chart(picture.coverage),) if picture.coverage and picture.coverage.bars else (),
        tables=(),
    )


def write_drawing(picture: Picture, cell: Cell, output: Path, replace: bool = True) -> None:
    """Write a drawing as a PNG or a page.

    Args:
        picture: The drawing.
        cell: The cell of the drawing.
        output: The file; its suffix selects the format.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The suffix is unknown, or the file cannot be written.
    """
    refuse_suffix(output)
    if output.suffix.lower() == ".png":
        write_png(picture, output, replace)
    else:
        write_bytes(output, page_bytes(picture_page(picture, cell, "drawing")), replace)


def _chart(coverage: Coverage) -> Chart:
    kinds = tuple((name, str(ink)) for name, ink in coverage.kinds)
    return Chart(coverage.title, kinds, tuple(Bar(bar.name, bar.counts) for bar in coverage.bars))
