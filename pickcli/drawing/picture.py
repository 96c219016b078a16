"""Contents of a picture, independent of what draws it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array

_ROOM = np.array([0.45, 0.25, 0.25])  # m


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
        faces: (F, 3) or (F, 4) corners of each triangle or quadrangle, in turn.
        ink: Colour.
    """

    corners: Array
    faces: NDArray[np.intp]
    ink: Colour


@dataclass(frozen=True, eq=False)
class DrawnLine:
    """A path of the tip of the cup, or the skeleton of the arm.

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
    """A named place of the tip.

    Attributes:
        place: (3,) m in the world.
        ink: Colour.
        name: Label.
        is_main: Whether the label is in larger print.
    """

    place: Array
    ink: Colour
    name: str
    is_main: bool = True


@dataclass(frozen=True)
class CoverageBar:
    """What is covered of one bin.

    Attributes:
        name: Name of the bin.
        counts: How many pairs are of each kind, the best kind first.
    """

    name: str
    counts: tuple[int, ...]


@dataclass(frozen=True)
class Coverage:
    """Bars for all bins.

    Attributes:
        title: Heading.
        kinds: What the counts of each bar stand for, with their colours.
        bars: One for each bin.
    """

    title: str
    kinds: tuple[tuple[str, Colour], ...]
    bars: tuple[CoverageBar, ...]


@dataclass(frozen=True, eq=False)
class Picture:
    """The cell in 3-D with lines and nodes, the coverage of its bins, and a few words.

    Attributes:
        title: Heading.
        words: Lines of text.
        solids: Of the cell and of the arm at home.
        lines: The arm first, then paths.
        nodes: Named places.
        coverage: Of the bins; None where nothing is stored.
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
        """Corners (3,) of the part of the world in which something moves, and some room around it."""
        paths = self.lines[1:] or self.lines
        points = np.vstack([*(line.points for line in paths), *(node.place for node in self.nodes)])
        return points.min(axis=0) - _ROOM, points.max(axis=0) + _ROOM
