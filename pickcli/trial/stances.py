"""How an item can lie on a floor: which side is down, and what it covers then."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array

MIN_SLENDERNESS = 0.35  # narrowest side of the footprint over the height: what stands thinner topples
WEIGHTS = (0.75, 0.20, 0.05)  # of the flattest stance, the next and the tallest


@dataclass(frozen=True, eq=False)
class Stance:
    """One side down.

    R_world_item: (3, 3) before any turn about the vertical
    footprint: (x, y) extents of the covered rectangle, m
    height: m
    is_level: whether its top is flat, so that others can lie on it
    """

    R_world_item: Array
    footprint: tuple[float, float]
    height: float
    is_level: bool


def stances(shape: Shape) -> list[tuple[Stance, float]]:
    """Every stable stance with its probability, the flattest first."""
    found = {
        round(stance.height, 6): stance for stance in (_stance(shape, axis) for axis in range(3)) if stance
    }
    ranked = [found[height] for height in sorted(found)]
    stable = [s for i, s in enumerate(ranked) if i == 0 or min(s.footprint) >= MIN_SLENDERNESS * s.height]
    weights = np.array(WEIGHTS[: len(stable)])
    return list(zip(stable, (weights / weights.sum()).tolist(), strict=True))


def _stance(shape: Shape, up: int) -> Stance | None:
    """The stance with one of the item's axes upwards."""
    if shape.kind is ShapeKind.CYLINDER and up == 1:
        return None  # the same as lying on its x axis
    R = np.roll(np.eye(3), up - 2, axis=1).T if up != 2 else np.eye(3)
    along = np.abs(R) @ shape.extents
    is_level = shape.kind is ShapeKind.BOX or (shape.kind is ShapeKind.CYLINDER and up == 2)
    return Stance(R, (float(along[0]), float(along[1])), float(along[2]), is_level)
