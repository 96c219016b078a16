"""Data of a page as one JSON document, described in docs/formats/page.md.

SI units. A pose is seven numbers: x, y, z in m and a unit quaternion x, y, z, w. Arrays over time are packed
(``packed_array``).
"""

from __future__ import annotations

from dataclasses import dataclass, fields, is_dataclass
from typing import Any

from pickcli.page.page_motion import Chapter, Lane, Mark, PageMotion, PathClearance, Signal
from pickcli.page.page_scene import (
    Fact,
    PageGroup,
    PageItem,
    PageLine,
    PageNode,
    PagePlace,
    PageRobot,
    Tone,
)

FORMAT, VERSION = "apc page", 1


@dataclass(frozen=True)
class Bar:
    """One row of a bar chart.

    Attributes:
        name: Heading.
        counts: Number of each kind.
    """

    name: str
    counts: tuple[int, ...]


@dataclass(frozen=True)
class Chart:
    """A chart of stacked bars.

    Attributes:
        title: Heading.
        kinds: Name and colour of each kind.
        bars: Rows.
    """

    title: str
    kinds: tuple[tuple[str, str], ...]
    bars: tuple[Bar, ...]


@dataclass(frozen=True)
class PageTable:
    """Rows of text.

    Attributes:
        title: Heading.
        columns: Headings of the columns.
        rows: Cells.
        tones: Tone of each row.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    tones: tuple[Tone, ...] = ()


@dataclass(frozen=True)
class PagePicture:
    """A picture of the panel.

    Attributes:
        title: Text above it.
        data: The picture as a data URI.
    """

    title: str
    data: str


@dataclass(frozen=True, eq=False)
class PageDocument:
    """All data of one page.

    Attributes:
        kind: "cell", "scene", "plan", "roadmap", "trajectory database", "trial", "trials", "grasps",
            "envelopes", "pallet", or that of a trial of something else than an order.
        title: Heading.
        subtitle: Text below the heading.
        facts: Rows of the panel.
        robot: The robot; None for pages without a cell.
        groups: Static bodies.
        items: Items at the start.
        places: Places with mouths.
        nodes: Named points.
        lines: Paths without time.
        legend: Name and colour of the kinds of lines.
        motion: Motion of robot and items, or None.
        lanes: Segments and devices.
        signals: Curves.
        clearance: Clearance along the path, or None.
        marks: Failures.
        chapters: Attempts.
        charts: Bar charts.
        tables: Tables of text.
        pictures: Pictures of looks.
        focus: Initial centre of the view in the world; empty for the centre of everything.
    """

    kind: str
    title: str
    subtitle: str
    facts: tuple[Fact, ...] = ()
    robot: PageRobot | None = None
    groups: tuple[PageGroup, ...] = ()
    items: tuple[PageItem, ...] = ()
    places: tuple[PagePlace, ...] = ()
    nodes: tuple[PageNode, ...] = ()
    lines: tuple[PageLine, ...] = ()
    legend: tuple[tuple[str, str], ...] = ()
    motion: PageMotion | None = None
    lanes: tuple[Lane, ...] = ()
    signals: tuple[Signal, ...] = ()
    clearance: PathClearance | None = None
    marks: tuple[Mark, ...] = ()
    chapters: tuple[Chapter, ...] = ()
    charts: tuple[Chart, ...] = ()
    tables: tuple[PageTable, ...] = ()
    pictures: tuple[PagePicture, ...] = ()
    focus: tuple[float, ...] = ()


def document_values(document: PageDocument) -> dict[str, Any]:
    """Convert the document to JSON values.

    Args:
        document: The document.

    Returns:
        Values by name, with ``format`` and ``version``.
    """
    return {"format": FORMAT, "version": VERSION, **_plain(document)}


def _plain(value: Any) -> Any:
    """Convert dataclasses to mappings, without empty values."""
    if is_dataclass(value) and not isinstance(value, type):
        values = {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
        return {name: each for name, each in values.items() if each is not None and each not in ("", [])}
    if isinstance(value, tuple):
        return [_plain(each) for each in value]
    return value
