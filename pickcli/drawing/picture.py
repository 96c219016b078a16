"""What a picture shows, whoever draws it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from pickcli.geometry import Array

_ROOM = np.array([0.45, 0.25, 0.25])  # m


class Colour(StrEnum):
    """Colours by meaning, as #rrggbb; safe for the colour-blind (after Okabe and Ito)."""

    POD = "#8c8c8c"
    TOTE = "#56b4e9"
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
class DrawnBox:
    """A box: corners (8, 3) in the world, m, in the order of the bits zyx of their number."""

    corners: Array
    ink: Colour


@dataclass(frozen=True, eq=False)
class DrawnLine:
    """A path (K, 3) of the tip of the cup, or the skeleton of the arm, in the world, m."""

    points: Array
    ink: Colour
    name: str = ""


@dataclass(frozen=True, eq=False)
class DrawnNode:
    """A named place (3,) of the tip in the world, m. is_main: in larger print."""

    place: Array
    ink: Colour
    name: str
    is_main: bool = True


@dataclass(frozen=True)
class CoverageBar:
    """What is covered of one bin: counts by what became of them, the best first."""

    name: str
    counts: tuple[int, ...]


@dataclass(frozen=True)
class Coverage:
    """Bars for all bins. kinds: what the counts of each bar stand for, with their colours."""

    title: str
    kinds: tuple[tuple[str, Colour], ...]
    bars: tuple[CoverageBar, ...]


@dataclass(frozen=True, eq=False)
class Picture:
    """The cell in 3-D with lines (the arm first) and nodes, the coverage of its bins, and a few words."""

    title: str
    words: tuple[str, ...]
    solids: tuple[DrawnBox, ...]
    lines: tuple[DrawnLine, ...]
    nodes: tuple[DrawnNode, ...]
    coverage: Coverage
    lines_by_ink: tuple[tuple[str, Colour], ...]  # the legend of the lines

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Corners (3,) of the part of the world in which something moves, and some room around it."""
        paths = self.lines[1:] or self.lines
        points = np.vstack([*(line.points for line in paths), *(node.place for node in self.nodes)])
        return points.min(axis=0) - _ROOM, points.max(axis=0) + _ROOM
