"""How an item is let go: the straight lines down to the release with it, and away from there without it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cartesian.line_following import Line
from pickcli.collision.checker import SceneChecker
from pickcli.geometry import Array
from pickcli.motion.segment import SegmentKind


@dataclass(frozen=True, eq=False)
class Step:
    """One proven straight line. touching: names that the cup, and the item in it, may touch on it."""

    kind: SegmentKind
    line: Line
    checker: SceneChecker
    speed: float  # m/s at the tool
    touching: frozenset[str] = frozenset()


@dataclass(frozen=True, eq=False)
class Landing:
    """One way to let the item go; each line starts where the one before ends."""

    inward: tuple[Step, ...]  # with the item, to the release
    away: tuple[Step, ...]  # empty
    cost: float  # s that a better place would be worth

    @property
    def start(self) -> Array:
        """Configuration (n,) in which the coarse motion arrives."""
        return np.asarray(self.inward[0].line.waypoints[0])
