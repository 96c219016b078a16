"""Contents of a picture, independent of the output format."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array

_BORDER = np.array([0.45, 0.25, 0.25])  # m around what is drawn, either way along x, y and z


class Colour(StrEnum):
    """Colours by meaning, as #rrggbb; safe for the colour-blind (after Okabe and Ito)."""

    POD = "#8c8c8c"
    TOTE = "#56b4e9"
    PLACE = "#a6761d"
    OBSTACLE = "#c8c8c8"
    ARM = "#404040"
    HOME = "#000000"
    BIN = "#0072b2"
    CAMERA = "#cc79a7"
    DELIVERY = "#d55e00"  # tote and drop poses
    OTHER = "#999999"
    GOOD = "#009e73"
    FAIR = "#e69f00"
    BAD = "#b2182b"


@dataclass(frozen=True, eq=False)
class DrawnSolid:
    """A convex solid.

    Attributes:
        corners: (K, 3) m in the world.
        faces: (F, 3) or (F, 4) indices of the corners of each triangle or quadrangle, in order.
        ink: Colour.
    """

    corners: Array
    faces: NDArray[np.intp]
    ink: Colour


@dataclass(frozen=True, eq=False)
class DrawnLine:
    """A path of the tool tip, or the skeleton of the arm.

    Attributes:
        points: (K, 3) m in the world.
        ink: Colour.
        name: Label.
    """

    points: Array
    ink: Colour
    name: str = ""


@dataclass(frozen=True, eq=False)
class DrawnNode:
    """A named position of the tip.

    Attributes:
        place: (3,) m in the world.
        ink: Colour.
        name: Label.
        is_main: Whether the label is larger.
    """

    place: Array
    ink: Colour
    name: str
    is_main: bool = True


@dataclass(frozen=True)
class CoverageBar:
    """Coverage of one bin.

    Attributes:
        name: Name of the bin.
        counts: Number of pairs of each kind, the best kind first.
    """

    name: str
    counts: tuple[int, ...]


@dataclass(frozen=True)
class Coverage:
    """Bars for all bins.

    Attributes:
        title: Heading.
        kinds: Names of the kinds in the counts, with their colours.
        bars: One bar per bin.
    """

    title: str
    kinds: tuple[tuple[str, Colour], ...]
    bars: tuple[CoverageBar, ...]


@dataclass(frozen=True, eq=False)
class Picture:
    """A 3-D view of the cell with lines and nodes, the coverage of its bins, and text.

    Attributes:
        title: Heading.
        words: Lines of text.
        solids: Solids of the cell, and of the arm at home.
        lines: The arm first, then paths.
        nodes: Named positions.
        coverage: Coverage of the bins, or None.
        lines_by_ink: The legend of the lines.
    """

    title: str
    words: tuple[str, ...]
    solids: tuple[DrawnSolid, ...]
    lines: tuple[DrawnLine, ...]
    nodes: tuple[DrawnNode, ...]
    coverage: Coverage | None
    lines_by_ink: tuple[tuple[str, Colour], ...]

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Corners (3,) of the box around all paths and nodes, with a margin."""
        paths = self.lines[1:] or self.lines
        points = np.vstack([*(line.points for line in paths), *(node.place for node in self.nodes)])
        return points.min(axis=0) - _BORDER, points.max(axis=0) + _BORDER
